"""The task `slide_block_to_target` under its known name."""

from rlbench.backend.task import Task


class SlideBlockToTarget(Task):
    """The task `slide_block_to_target` of our library."""

    library_name = "slide_block_to_target"
