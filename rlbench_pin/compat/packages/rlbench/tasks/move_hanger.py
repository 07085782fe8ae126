"""The task `move_hanger` under its known name."""

from rlbench.backend.task import Task


class MoveHanger(Task):
    """The task `move_hanger` of our library."""

    library_name = "move_hanger"
