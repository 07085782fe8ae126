"""The task `slide_block_to_color_target` under its known name."""

from rlbench.backend.task import Task


class SlideBlockToColorTarget(Task):
    """The task `slide_block_to_color_target` of our library."""

    library_name = "slide_block_to_color_target"
