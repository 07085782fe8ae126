"""Which tasks the few-shot and multi-task sets hold."""

from __future__ import annotations

_FS10 = (
    *("reach_target", "close_box", "close_microwave", "plug_charger_in_power_supply", "toilet_seat_down"),
    *("take_umbrella_out_of_umbrella_stand", "put_umbrella_in_umbrella_stand", "slide_cabinet_open", "close_fridge"),
    "pick_and_lift",
)
_FS10_TEST = ("open_box", "open_microwave", "unplug_charger", "toilet_seat_up", "open_fridge")
_FS25 = (
    *(*_FS10, *_FS10_TEST, "turn_tap", "light_bulb_in", "basketball_in_hoop", "open_window", "close_door", "push_button"),
    *("put_item_in_drawer", "open_drawer", "close_drawer", "turn_oven_on"),
)
_FS25_TEST = ("light_bulb_out", "tv_on", "open_oven", "open_door", "take_item_out_of_drawer")
_FS50 = (
    *(*_FS25, *_FS25_TEST, "beat_the_buzz", "block_pyramid", "change_clock", "close_jar", "close_laptop_lid"),
    *("empty_container", "empty_dishwasher", "get_ice_from_fridge", "hang_frame_on_hanger", "insert_onto_square_peg"),
    *("put_rubbish_in_bin", "put_shoes_in_box", "put_toilet_roll_on_stand", "put_tray_in_oven", "reach_and_drag"),
    *("remove_cups", "scoop_with_spatula", "set_the_table", "setup_checkers", "slide_block_to_target"),
)
_FS50_TEST = ("hockey", "insert_usb_in_computer", "press_switch", "play_jenga", "meat_off_grill")
_FS95 = (
    *(*_FS50, *_FS50_TEST, "hit_ball_with_queue", "screw_nail", "lamp_off", "lamp_on", "meat_on_grill", "move_hanger"),
    *("open_jar", "open_wine_bottle", "place_cups", "place_hanger_on_rack", "place_shape_in_shape_sorter"),
    *("put_bottle_in_fridge", "put_knife_in_knife_block", "put_money_in_safe", "put_plate_in_colored_dish_rack"),
    *("slide_cabinet_open_and_place_cups", "stack_blocks", "stack_cups", "stack_wine", "straighten_rope"),
    *("sweep_to_dustpan", "take_cup_out_from_cabinet", "take_frame_off_hanger", "take_lid_off_saucepan"),
    *("take_money_out_safe", "take_off_weighing_scales", "take_plate_off_colored_dish_rack", "take_shoes_out_of_box"),
    *("take_toilet_roll_off_stand", "take_usb_out_of_computer", "water_plants", "weighing_scales", "wipe_desk"),
    *("change_channel", "open_grill", "close_grill", "solve_puzzle", "pick_up_cup", "phone_on_base"),
    "pour_from_cup_to_cup",
)
_FS95_TEST = (
    *("put_knife_on_chopping_board", "put_books_on_bookshelf", "push_buttons", "put_groceries_in_cupboard"),
    "take_tray_out_of_oven",
)

TASK_SETS: dict[str, dict[str, tuple[str, ...]]] = {
    "FS10_V1": {"train": _FS10, "test": _FS10_TEST},
    "FS25_V1": {"train": _FS25, "test": _FS25_TEST},
    "FS50_V1": {"train": _FS50, "test": _FS50_TEST},
    "FS95_V1": {"train": _FS95, "test": _FS95_TEST},
    "MT15_V1": {"train": (*_FS10, *_FS10_TEST)},
    "MT30_V1": {"train": (*_FS25, *_FS25_TEST)},
    "MT55_V1": {"train": (*_FS50, *_FS50_TEST)},
    "MT100_V1": {"train": (*_FS95, *_FS95_TEST)},
}
"""Name of the set -> `train` and, in few-shot sets, `test` -> names of tasks."""
