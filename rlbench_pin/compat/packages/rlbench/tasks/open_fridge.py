"""The task `open_fridge` under its known name."""

from rlbench.backend.task import Task


class OpenFridge(Task):
    """The task `open_fridge` of our library."""

    library_name = "open_fridge"
