"""The task `place_hanger_on_rack` under its known name."""

from rlbench.backend.task import Task


class PlaceHangerOnRack(Task):
    """The task `place_hanger_on_rack` of our library."""

    library_name = "place_hanger_on_rack"
