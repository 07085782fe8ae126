"""The task `put_all_groceries_in_cupboard` under its known name."""

from rlbench.backend.task import Task


class PutAllGroceriesInCupboard(Task):
    """The task `put_all_groceries_in_cupboard` of our library."""

    library_name = "put_all_groceries_in_cupboard"
