"""The task `put_shoes_in_box` under its known name."""

from rlbench.backend.task import Task


class PutShoesInBox(Task):
    """The task `put_shoes_in_box` of our library."""

    library_name = "put_shoes_in_box"
