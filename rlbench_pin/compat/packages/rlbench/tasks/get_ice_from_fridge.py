"""The task `get_ice_from_fridge` under its known name."""

from rlbench.backend.task import Task


class GetIceFromFridge(Task):
    """The task `get_ice_from_fridge` of our library."""

    library_name = "get_ice_from_fridge"
