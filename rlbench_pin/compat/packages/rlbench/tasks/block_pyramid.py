"""The task `block_pyramid` under its known name."""

from rlbench.backend.task import Task


class BlockPyramid(Task):
    """The task `block_pyramid` of our library."""

    library_name = "block_pyramid"
