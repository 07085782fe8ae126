"""The task `hockey` under its known name."""

from rlbench.backend.task import Task


class Hockey(Task):
    """The task `hockey` of our library."""

    library_name = "hockey"
