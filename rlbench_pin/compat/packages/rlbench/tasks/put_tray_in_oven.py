"""The task `put_tray_in_oven` under its known name."""

from rlbench.backend.task import Task


class PutTrayInOven(Task):
    """The task `put_tray_in_oven` of our library."""

    library_name = "put_tray_in_oven"
