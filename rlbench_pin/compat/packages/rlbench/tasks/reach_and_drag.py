"""The task `reach_and_drag` under its known name."""

from rlbench.backend.task import Task


class ReachAndDrag(Task):
    """The task `reach_and_drag` of our library."""

    library_name = "reach_and_drag"
