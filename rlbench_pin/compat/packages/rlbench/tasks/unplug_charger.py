"""The task `unplug_charger` under its known name."""

from rlbench.backend.task import Task


class UnplugCharger(Task):
    """The task `unplug_charger` of our library."""

    library_name = "unplug_charger"
