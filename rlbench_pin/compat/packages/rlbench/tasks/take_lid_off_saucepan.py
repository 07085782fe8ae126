"""The task `take_lid_off_saucepan` under its known name."""

from rlbench.backend.task import Task


class TakeLidOffSaucepan(Task):
    """The task `take_lid_off_saucepan` of our library."""

    library_name = "take_lid_off_saucepan"
