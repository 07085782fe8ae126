"""The task `close_door` under its known name."""

from rlbench.backend.task import Task


class CloseDoor(Task):
    """The task `close_door` of our library."""

    library_name = "close_door"
