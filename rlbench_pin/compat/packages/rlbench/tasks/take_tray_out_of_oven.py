"""The task `take_tray_out_of_oven` under its known name."""

from rlbench.backend.task import Task


class TakeTrayOutOfOven(Task):
    """The task `take_tray_out_of_oven` of our library."""

    library_name = "take_tray_out_of_oven"
