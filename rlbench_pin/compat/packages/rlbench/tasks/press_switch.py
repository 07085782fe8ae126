"""The task `press_switch` under its known name."""

from rlbench.backend.task import Task


class PressSwitch(Task):
    """The task `press_switch` of our library."""

    library_name = "press_switch"
