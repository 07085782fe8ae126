"""The task `open_drawer` under its known name."""

from rlbench.backend.task import Task


class OpenDrawer(Task):
    """The task `open_drawer` of our library."""

    library_name = "open_drawer"
