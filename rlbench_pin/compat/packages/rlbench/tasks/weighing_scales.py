"""The task `weighing_scales` under its known name."""

from rlbench.backend.task import Task


class WeighingScales(Task):
    """The task `weighing_scales` of our library."""

    library_name = "weighing_scales"
