"""The task `setup_chess` under its known name."""

from rlbench.backend.task import Task


class SetupChess(Task):
    """The task `setup_chess` of our library."""

    library_name = "setup_chess"
