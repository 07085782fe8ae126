"""The task `open_box` under its known name."""

from rlbench.backend.task import Task


class OpenBox(Task):
    """The task `open_box` of our library."""

    library_name = "open_box"
