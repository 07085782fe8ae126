"""The task `sweep_to_dustpan` under its known name."""

from rlbench.backend.task import Task


class SweepToDustpan(Task):
    """The task `sweep_to_dustpan` of our library."""

    library_name = "sweep_to_dustpan"
