"""The task `open_washing_machine` under its known name."""

from rlbench.backend.task import Task


class OpenWashingMachine(Task):
    """The task `open_washing_machine` of our library."""

    library_name = "open_washing_machine"
