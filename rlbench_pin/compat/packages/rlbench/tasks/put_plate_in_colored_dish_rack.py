"""The task `put_plate_in_colored_dish_rack` under its known name."""

from rlbench.backend.task import Task


class PutPlateInColoredDishRack(Task):
    """The task `put_plate_in_colored_dish_rack` of our library."""

    library_name = "put_plate_in_colored_dish_rack"
