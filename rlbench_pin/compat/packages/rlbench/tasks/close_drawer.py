"""The task `close_drawer` under its known name."""

from rlbench.backend.task import Task


class CloseDrawer(Task):
    """The task `close_drawer` of our library."""

    library_name = "close_drawer"
