"""The task `remove_cups` under its known name."""

from rlbench.backend.task import Task


class RemoveCups(Task):
    """The task `remove_cups` of our library."""

    library_name = "remove_cups"
