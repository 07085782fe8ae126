"""The task `slide_cabinet_open_and_place_cups` under its known name."""

from rlbench.backend.task import Task


class SlideCabinetOpenAndPlaceCups(Task):
    """The task `slide_cabinet_open_and_place_cups` of our library."""

    library_name = "slide_cabinet_open_and_place_cups"
