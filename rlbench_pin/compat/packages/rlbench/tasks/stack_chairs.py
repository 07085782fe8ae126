"""The task `stack_chairs` under its known name."""

from rlbench.backend.task import Task


class StackChairs(Task):
    """The task `stack_chairs` of our library."""

    library_name = "stack_chairs"
