"""The task `close_microwave` under its known name."""

from rlbench.backend.task import Task


class CloseMicrowave(Task):
    """The task `close_microwave` of our library."""

    library_name = "close_microwave"
