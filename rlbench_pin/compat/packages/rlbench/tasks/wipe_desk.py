"""The task `wipe_desk` under its known name."""

from rlbench.backend.task import Task


class WipeDesk(Task):
    """The task `wipe_desk` of our library."""

    library_name = "wipe_desk"
