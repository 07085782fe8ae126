"""The task `open_door` under its known name."""

from rlbench.backend.task import Task


class OpenDoor(Task):
    """The task `open_door` of our library."""

    library_name = "open_door"
