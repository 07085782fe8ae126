"""The task `reach_target` under its known name."""

from rlbench.backend.task import Task


class ReachTarget(Task):
    """The task `reach_target` of our library."""

    library_name = "reach_target"
