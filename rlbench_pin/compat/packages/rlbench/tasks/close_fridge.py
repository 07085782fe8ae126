"""The task `close_fridge` under its known name."""

from rlbench.backend.task import Task


class CloseFridge(Task):
    """The task `close_fridge` of our library."""

    library_name = "close_fridge"
