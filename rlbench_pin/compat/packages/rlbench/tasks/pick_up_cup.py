"""The task `pick_up_cup` under its known name."""

from rlbench.backend.task import Task


class PickUpCup(Task):
    """The task `pick_up_cup` of our library."""

    library_name = "pick_up_cup"
