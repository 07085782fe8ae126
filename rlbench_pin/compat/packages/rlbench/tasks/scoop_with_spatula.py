"""The task `scoop_with_spatula` under its known name."""

from rlbench.backend.task import Task


class ScoopWithSpatula(Task):
    """The task `scoop_with_spatula` of our library."""

    library_name = "scoop_with_spatula"
