"""The task names that users of RLBench know, and the classes of our library behind them."""

from __future__ import annotations

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.tasks import Task, task_class, task_names

KNOWN_TASKS: tuple[str, ...] = (
    *("basketball_in_hoop", "beat_the_buzz", "block_pyramid", "change_channel", "change_clock", "close_box", "close_door"),
    *("close_drawer", "close_fridge", "close_grill", "close_jar", "close_laptop_lid", "close_microwave", "empty_container"),
    *("empty_dishwasher", "get_ice_from_fridge", "hang_frame_on_hanger", "hit_ball_with_queue", "hockey"),
    *("insert_onto_square_peg", "insert_usb_in_computer", "lamp_off", "lamp_on", "lift_numbered_block", "light_bulb_in"),
    *("light_bulb_out", "meat_off_grill", "meat_on_grill", "move_hanger", "open_box", "open_door", "open_drawer"),
    *("open_fridge", "open_grill", "open_jar", "open_microwave", "open_oven", "open_washing_machine", "open_window"),
    *("open_wine_bottle", "phone_on_base", "pick_and_lift", "pick_and_lift_small", "pick_up_cup", "place_cups"),
    *("place_hanger_on_rack", "place_shape_in_shape_sorter", "play_jenga", "plug_charger_in_power_supply"),
    *("pour_from_cup_to_cup", "press_switch", "push_button", "push_buttons", "put_all_groceries_in_cupboard"),
    *("put_books_on_bookshelf", "put_bottle_in_fridge", "put_groceries_in_cupboard", "put_item_in_drawer"),
    *("put_knife_in_knife_block", "put_knife_on_chopping_board", "put_money_in_safe", "put_plate_in_colored_dish_rack"),
    *("put_rubbish_in_bin", "put_shoes_in_box", "put_toilet_roll_on_stand", "put_tray_in_oven"),
    *("put_umbrella_in_umbrella_stand", "reach_and_drag", "reach_target", "remove_cups", "scoop_with_spatula", "screw_nail"),
    *("set_the_table", "setup_checkers", "setup_chess", "slide_block_to_target", "slide_cabinet_open"),
    *("slide_cabinet_open_and_place_cups", "solve_puzzle", "stack_blocks", "stack_chairs", "stack_cups", "stack_wine"),
    *("straighten_rope", "sweep_to_dustpan", "take_cup_out_from_cabinet", "take_frame_off_hanger", "take_item_out_of_drawer"),
    *("take_lid_off_saucepan", "take_money_out_safe", "take_off_weighing_scales", "take_plate_off_colored_dish_rack"),
    *("take_shoes_out_of_box", "take_toilet_roll_off_stand", "take_tray_out_of_oven", "take_umbrella_out_of_umbrella_stand"),
    *("take_usb_out_of_computer", "toilet_seat_down", "toilet_seat_up", "turn_oven_on", "turn_tap", "tv_on"),
    *("unplug_charger", "water_plants", "weighing_scales", "wipe_desk"),
)
"""The 106 tasks of the public task set."""

PERACT_TASKS: tuple[str, ...] = (
    *("place_wine_at_rack_location", "slide_block_to_color_target", "sweep_to_dustpan_of_size"),
    *("put_rubbish_in_color_bin", "set_clock_to_time", "put_books_at_shelf_location"),
)
"""Tasks that the PerAct dialect adds."""


class MissingTask(RlbenchPinError, NotImplementedError):
    """A task of the public task set that our library does not have yet; `name` is its name."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(
            f"The task '{name}' is known by name, but it is not in the library of rlbench_pin yet, which has {len(task_names())} "
            "tasks. `rlbench-pin list` prints them; os.listdir(rlbench.backend.task.TASKS_PATH) lists their files."
        )


def library_task(name: str) -> type[Task]:
    """Return the class of a task of our library.

    Raises:
        MissingTask: The library has no task of that name yet.
    """
    if name not in task_names():
        raise MissingTask(name)
    return task_class(name)


def check_present(name: str) -> None:
    """Raise MissingTask unless the library has a task of that name."""
    if name not in task_names():
        raise MissingTask(name)


def all_tasks() -> tuple[str, ...]:
    """Return all names that programs may ask for: the public set, PerAct's, and what our library has besides."""
    return tuple(sorted({*KNOWN_TASKS, *PERACT_TASKS, *task_names()}))
