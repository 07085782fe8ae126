"""The task `open_window` under its known name."""

from rlbench.backend.task import Task


class OpenWindow(Task):
    """The task `open_window` of our library."""

    library_name = "open_window"
