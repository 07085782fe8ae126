"""The task `set_the_table` under its known name."""

from rlbench.backend.task import Task


class SetTheTable(Task):
    """The task `set_the_table` of our library."""

    library_name = "set_the_table"
