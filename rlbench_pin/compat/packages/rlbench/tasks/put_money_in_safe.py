"""The task `put_money_in_safe` under its known name."""

from rlbench.backend.task import Task


class PutMoneyInSafe(Task):
    """The task `put_money_in_safe` of our library."""

    library_name = "put_money_in_safe"
