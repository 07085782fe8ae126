"""The task `open_oven` under its known name."""

from rlbench.backend.task import Task


class OpenOven(Task):
    """The task `open_oven` of our library."""

    library_name = "open_oven"
