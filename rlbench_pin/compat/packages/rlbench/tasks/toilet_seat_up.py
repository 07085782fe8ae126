"""The task `toilet_seat_up` under its known name."""

from rlbench.backend.task import Task


class ToiletSeatUp(Task):
    """The task `toilet_seat_up` of our library."""

    library_name = "toilet_seat_up"
