"""The task `take_cup_out_from_cabinet` under its known name."""

from rlbench.backend.task import Task


class TakeCupOutFromCabinet(Task):
    """The task `take_cup_out_from_cabinet` of our library."""

    library_name = "take_cup_out_from_cabinet"
