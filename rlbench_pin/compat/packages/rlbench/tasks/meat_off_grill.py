"""The task `meat_off_grill` under its known name."""

from rlbench.backend.task import Task


class MeatOffGrill(Task):
    """The task `meat_off_grill` of our library."""

    library_name = "meat_off_grill"
