"""The task `put_groceries_in_cupboard` under its known name."""

from rlbench.backend.task import Task


class PutGroceriesInCupboard(Task):
    """The task `put_groceries_in_cupboard` of our library."""

    library_name = "put_groceries_in_cupboard"
