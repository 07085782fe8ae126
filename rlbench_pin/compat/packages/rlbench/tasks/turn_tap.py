"""The task `turn_tap` under its known name."""

from rlbench.backend.task import Task


class TurnTap(Task):
    """The task `turn_tap` of our library."""

    library_name = "turn_tap"
