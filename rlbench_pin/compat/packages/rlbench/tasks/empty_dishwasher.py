"""The task `empty_dishwasher` under its known name."""

from rlbench.backend.task import Task


class EmptyDishwasher(Task):
    """The task `empty_dishwasher` of our library."""

    library_name = "empty_dishwasher"
