"""The task `empty_container` under its known name."""

from rlbench.backend.task import Task


class EmptyContainer(Task):
    """The task `empty_container` of our library."""

    library_name = "empty_container"
