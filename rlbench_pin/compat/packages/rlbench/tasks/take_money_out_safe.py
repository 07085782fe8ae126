"""The task `take_money_out_safe` under its known name."""

from rlbench.backend.task import Task


class TakeMoneyOutSafe(Task):
    """The task `take_money_out_safe` of our library."""

    library_name = "take_money_out_safe"
