"""The task `meat_on_grill` under its known name."""

from rlbench.backend.task import Task


class MeatOnGrill(Task):
    """The task `meat_on_grill` of our library."""

    library_name = "meat_on_grill"
