"""The task `basketball_in_hoop` under its known name."""

from rlbench.backend.task import Task


class BasketballInHoop(Task):
    """The task `basketball_in_hoop` of our library."""

    library_name = "basketball_in_hoop"
