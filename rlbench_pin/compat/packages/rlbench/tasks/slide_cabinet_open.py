"""The task `slide_cabinet_open` under its known name."""

from rlbench.backend.task import Task


class SlideCabinetOpen(Task):
    """The task `slide_cabinet_open` of our library."""

    library_name = "slide_cabinet_open"
