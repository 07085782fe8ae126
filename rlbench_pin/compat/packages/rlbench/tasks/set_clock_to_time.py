"""The task `set_clock_to_time` under its known name."""

from rlbench.backend.task import Task


class SetClockToTime(Task):
    """The task `set_clock_to_time` of our library."""

    library_name = "set_clock_to_time"
