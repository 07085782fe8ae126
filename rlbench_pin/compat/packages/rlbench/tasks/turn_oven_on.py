"""The task `turn_oven_on` under its known name."""

from rlbench.backend.task import Task


class TurnOvenOn(Task):
    """The task `turn_oven_on` of our library."""

    library_name = "turn_oven_on"
