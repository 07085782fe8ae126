"""The task `place_wine_at_rack_location` under its known name."""

from rlbench.backend.task import Task


class PlaceWineAtRackLocation(Task):
    """The task `place_wine_at_rack_location` of our library."""

    library_name = "place_wine_at_rack_location"
