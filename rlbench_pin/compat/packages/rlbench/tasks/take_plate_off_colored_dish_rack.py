"""The task `take_plate_off_colored_dish_rack` under its known name."""

from rlbench.backend.task import Task


class TakePlateOffColoredDishRack(Task):
    """The task `take_plate_off_colored_dish_rack` of our library."""

    library_name = "take_plate_off_colored_dish_rack"
