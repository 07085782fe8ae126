"""The task `take_item_out_of_drawer` under its known name."""

from rlbench.backend.task import Task


class TakeItemOutOfDrawer(Task):
    """The task `take_item_out_of_drawer` of our library."""

    library_name = "take_item_out_of_drawer"
