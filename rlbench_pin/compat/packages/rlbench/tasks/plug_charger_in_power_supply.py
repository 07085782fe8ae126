"""The task `plug_charger_in_power_supply` under its known name."""

from rlbench.backend.task import Task


class PlugChargerInPowerSupply(Task):
    """The task `plug_charger_in_power_supply` of our library."""

    library_name = "plug_charger_in_power_supply"
