"""The task `straighten_rope` under its known name."""

from rlbench.backend.task import Task


class StraightenRope(Task):
    """The task `straighten_rope` of our library."""

    library_name = "straighten_rope"
