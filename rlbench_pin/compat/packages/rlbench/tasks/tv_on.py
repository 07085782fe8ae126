"""The task `tv_on` under its known name."""

from rlbench.backend.task import Task


class TvOn(Task):
    """The task `tv_on` of our library."""

    library_name = "tv_on"
