"""The task `light_bulb_out` under its known name."""

from rlbench.backend.task import Task


class LightBulbOut(Task):
    """The task `light_bulb_out` of our library."""

    library_name = "light_bulb_out"
