"""The task `close_laptop_lid` under its known name."""

from rlbench.backend.task import Task


class CloseLaptopLid(Task):
    """The task `close_laptop_lid` of our library."""

    library_name = "close_laptop_lid"
