"""The task `pour_from_cup_to_cup` under its known name."""

from rlbench.backend.task import Task


class PourFromCupToCup(Task):
    """The task `pour_from_cup_to_cup` of our library."""

    library_name = "pour_from_cup_to_cup"
