"""The task `pick_and_lift` under its known name."""

from rlbench.backend.task import Task


class PickAndLift(Task):
    """The task `pick_and_lift` of our library."""

    library_name = "pick_and_lift"
