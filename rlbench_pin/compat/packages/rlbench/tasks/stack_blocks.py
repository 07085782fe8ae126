"""The task `stack_blocks` under its known name."""

from rlbench.backend.task import Task


class StackBlocks(Task):
    """The task `stack_blocks` of our library."""

    library_name = "stack_blocks"
