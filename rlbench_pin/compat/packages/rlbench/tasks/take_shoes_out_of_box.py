"""The task `take_shoes_out_of_box` under its known name."""

from rlbench.backend.task import Task


class TakeShoesOutOfBox(Task):
    """The task `take_shoes_out_of_box` of our library."""

    library_name = "take_shoes_out_of_box"
