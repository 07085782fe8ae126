"""The task `open_grill` under its known name."""

from rlbench.backend.task import Task


class OpenGrill(Task):
    """The task `open_grill` of our library."""

    library_name = "open_grill"
