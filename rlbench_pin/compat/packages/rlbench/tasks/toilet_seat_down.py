"""The task `toilet_seat_down` under its known name."""

from rlbench.backend.task import Task


class ToiletSeatDown(Task):
    """The task `toilet_seat_down` of our library."""

    library_name = "toilet_seat_down"
