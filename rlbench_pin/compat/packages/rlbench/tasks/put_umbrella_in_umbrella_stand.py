"""The task `put_umbrella_in_umbrella_stand` under its known name."""

from rlbench.backend.task import Task


class PutUmbrellaInUmbrellaStand(Task):
    """The task `put_umbrella_in_umbrella_stand` of our library."""

    library_name = "put_umbrella_in_umbrella_stand"
