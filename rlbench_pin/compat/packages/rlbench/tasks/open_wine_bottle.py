"""The task `open_wine_bottle` under its known name."""

from rlbench.backend.task import Task


class OpenWineBottle(Task):
    """The task `open_wine_bottle` of our library."""

    library_name = "open_wine_bottle"
