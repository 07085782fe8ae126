"""The task `take_off_weighing_scales` under its known name."""

from rlbench.backend.task import Task


class TakeOffWeighingScales(Task):
    """The task `take_off_weighing_scales` of our library."""

    library_name = "take_off_weighing_scales"
