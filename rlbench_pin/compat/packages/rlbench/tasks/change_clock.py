"""The task `change_clock` under its known name."""

from rlbench.backend.task import Task


class ChangeClock(Task):
    """The task `change_clock` of our library."""

    library_name = "change_clock"
