"""The task `lamp_off` under its known name."""

from rlbench.backend.task import Task


class LampOff(Task):
    """The task `lamp_off` of our library."""

    library_name = "lamp_off"
