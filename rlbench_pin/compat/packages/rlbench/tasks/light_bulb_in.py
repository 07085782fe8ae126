"""The task `light_bulb_in` under its known name."""

from rlbench.backend.task import Task


class LightBulbIn(Task):
    """The task `light_bulb_in` of our library."""

    library_name = "light_bulb_in"
