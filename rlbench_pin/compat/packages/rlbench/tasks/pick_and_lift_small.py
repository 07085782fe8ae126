"""The task `pick_and_lift_small` under its known name."""

from rlbench.backend.task import Task


class PickAndLiftSmall(Task):
    """The task `pick_and_lift_small` of our library."""

    library_name = "pick_and_lift_small"
