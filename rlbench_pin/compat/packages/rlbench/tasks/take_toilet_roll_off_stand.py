"""The task `take_toilet_roll_off_stand` under its known name."""

from rlbench.backend.task import Task


class TakeToiletRollOffStand(Task):
    """The task `take_toilet_roll_off_stand` of our library."""

    library_name = "take_toilet_roll_off_stand"
