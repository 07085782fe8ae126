"""The task `change_channel` under its known name."""

from rlbench.backend.task import Task


class ChangeChannel(Task):
    """The task `change_channel` of our library."""

    library_name = "change_channel"
