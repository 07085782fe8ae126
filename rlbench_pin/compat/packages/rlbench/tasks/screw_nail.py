"""The task `screw_nail` under its known name."""

from rlbench.backend.task import Task


class ScrewNail(Task):
    """The task `screw_nail` of our library."""

    library_name = "screw_nail"
