"""The task `close_box` under its known name."""

from rlbench.backend.task import Task


class CloseBox(Task):
    """The task `close_box` of our library."""

    library_name = "close_box"
