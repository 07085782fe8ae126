"""The task `lift_numbered_block` under its known name."""

from rlbench.backend.task import Task


class LiftNumberedBlock(Task):
    """The task `lift_numbered_block` of our library."""

    library_name = "lift_numbered_block"
