"""The task `stack_cups` under its known name."""

from rlbench.backend.task import Task


class StackCups(Task):
    """The task `stack_cups` of our library."""

    library_name = "stack_cups"
