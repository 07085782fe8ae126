"""The task `sweep_to_dustpan_of_size` under its known name."""

from rlbench.backend.task import Task


class SweepToDustpanOfSize(Task):
    """The task `sweep_to_dustpan_of_size` of our library."""

    library_name = "sweep_to_dustpan_of_size"
