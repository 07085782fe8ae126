"""The task `put_knife_on_chopping_board` under its known name."""

from rlbench.backend.task import Task


class PutKnifeOnChoppingBoard(Task):
    """The task `put_knife_on_chopping_board` of our library."""

    library_name = "put_knife_on_chopping_board"
