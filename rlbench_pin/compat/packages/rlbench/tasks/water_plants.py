"""The task `water_plants` under its known name."""

from rlbench.backend.task import Task


class WaterPlants(Task):
    """The task `water_plants` of our library."""

    library_name = "water_plants"
