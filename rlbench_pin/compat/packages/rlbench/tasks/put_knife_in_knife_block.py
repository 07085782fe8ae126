"""The task `put_knife_in_knife_block` under its known name."""

from rlbench.backend.task import Task


class PutKnifeInKnifeBlock(Task):
    """The task `put_knife_in_knife_block` of our library."""

    library_name = "put_knife_in_knife_block"
