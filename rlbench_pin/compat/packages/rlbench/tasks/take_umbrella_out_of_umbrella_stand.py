"""The task `take_umbrella_out_of_umbrella_stand` under its known name."""

from rlbench.backend.task import Task


class TakeUmbrellaOutOfUmbrellaStand(Task):
    """The task `take_umbrella_out_of_umbrella_stand` of our library."""

    library_name = "take_umbrella_out_of_umbrella_stand"
