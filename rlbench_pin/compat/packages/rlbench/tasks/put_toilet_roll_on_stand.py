"""The task `put_toilet_roll_on_stand` under its known name."""

from rlbench.backend.task import Task


class PutToiletRollOnStand(Task):
    """The task `put_toilet_roll_on_stand` of our library."""

    library_name = "put_toilet_roll_on_stand"
