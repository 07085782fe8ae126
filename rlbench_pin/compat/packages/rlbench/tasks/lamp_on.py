"""The task `lamp_on` under its known name."""

from rlbench.backend.task import Task


class LampOn(Task):
    """The task `lamp_on` of our library."""

    library_name = "lamp_on"
