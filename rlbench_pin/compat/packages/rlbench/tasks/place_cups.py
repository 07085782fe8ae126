"""The task `place_cups` under its known name."""

from rlbench.backend.task import Task


class PlaceCups(Task):
    """The task `place_cups` of our library."""

    library_name = "place_cups"
