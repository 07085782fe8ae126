"""The task `stack_wine` under its known name."""

from rlbench.backend.task import Task


class StackWine(Task):
    """The task `stack_wine` of our library."""

    library_name = "stack_wine"
