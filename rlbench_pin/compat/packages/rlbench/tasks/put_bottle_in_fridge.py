"""The task `put_bottle_in_fridge` under its known name."""

from rlbench.backend.task import Task


class PutBottleInFridge(Task):
    """The task `put_bottle_in_fridge` of our library."""

    library_name = "put_bottle_in_fridge"
