"""The task `close_grill` under its known name."""

from rlbench.backend.task import Task


class CloseGrill(Task):
    """The task `close_grill` of our library."""

    library_name = "close_grill"
