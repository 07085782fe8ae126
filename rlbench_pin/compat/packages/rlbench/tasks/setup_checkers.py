"""The task `setup_checkers` under its known name."""

from rlbench.backend.task import Task


class SetupCheckers(Task):
    """The task `setup_checkers` of our library."""

    library_name = "setup_checkers"
