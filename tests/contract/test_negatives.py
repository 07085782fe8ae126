"""No accidental success: a demonstration without its decisive action, or with a faulty one, reaches no goal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.demos import DemoPlayer, Omission, try_play
from rlbench_pin.tasks import Task, task_class, task_scene


@dataclass(frozen=True)
class Negative:
    """What is done wrong in a demonstration."""

    omit: Omission = Omission()
    """What is left out."""
    spoil: Callable[[Task], None] = lambda task: None
    """Changes the script of an episode that has begun."""
    done: Callable[[Task], bool] = lambda task: True
    """What must have been done in the end all the same, lest the demonstration fails for another reason."""
    variation: int = -1
    """Variation; -1 draws one."""


def moved(name: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Callable[[Task], None]:
    """Return what moves a waypoint in the axes of its parent [m]."""

    def move(task: Task) -> None:
        frame = task.world.frame(name)
        frame.set_local([*(frame.local[:3] + [x, y, z]), *frame.local[3:]])

    return move


def holding(name: str) -> Callable[[Task], bool]:
    """Return the question whether a body is held."""
    return lambda task: name in task.gripper.grasped


def press_backwards(task: Task) -> None:
    """Press all buttons from the last to the first."""
    last = len(task.buttons) - 1
    task.register_waypoint_ability_start(0, lambda waypoint: waypoint.frame.set_parent(f"button{last - task.round}"))


def pull_without_a_turn(task: Task) -> None:
    """Pull the gripper straight up, as it is."""
    task.world.frame("waypoint2").set_local([0.0, 0.0, -0.12, 0.0, 0.0, 0.0, 1.0])


def turn_the_hand_too_far(task: Task) -> None:
    """Turn the long hand of the clock by two quarters, where one is asked for."""
    task.quarters = (2,)  # type: ignore[attr-defined]


def it_is_half_past(task: Task) -> bool:
    """Whether the long hand points at six."""
    return task.world.sensor("half_past").detects("clock")


def turn_the_left_handle(task: Task) -> None:
    """Turn the left handle of the tap, whichever is asked for."""
    task.world.frame("waypoint1").set_parent("left_grip")


def left_handle_is_turned(task: Task) -> bool:
    """Whether the left handle of the tap was turned by more than a quarter."""
    return abs(task.world.joint("tap/left").position) > 1.57


def tip_is_near_the_ball(task: Task) -> bool:
    """Whether the tip has come near the ball, whose radius is 2.5 cm."""
    return float(np.linalg.norm(task.robot.tip_pose()[:3] - task.world.body("target").position)) < 0.035


def close_the_other_jar(task: Task) -> None:
    """Carry the lid to the jar that is not asked for."""
    for name in ("waypoint3", "waypoint4"):
        task.world.frame(name).set_parent(other_jar(task.world.frame("goal").parent))


def open_the_other_jar(task: Task) -> None:
    """Take the lid of the jar that is not asked for."""
    task.world.frame("waypoint1").set_parent(other_jar(task.world.frame("goal").parent))


def other_jar(name: str) -> str:
    """Return the name of the other one of two jars."""
    return "jar1" if name == "jar0" else "jar0"


def other_jar_is_shut(task: Task) -> bool:
    """Whether the lid was let go on the neck of the jar that is not asked for; its middle lies 45 mm above that of the jar."""
    jar = task.world.body(other_jar(task.world.frame("goal").parent))
    place = task.world.body("lid").position - jar.position
    return not task.gripper.grasped and bool(np.abs(place - [0.0, 0.0, 0.045]).max() < 0.003)


def other_lid_is_in_the_ring(task: Task) -> bool:
    """Whether the lid of the jar that is not asked for was let go in the ring."""
    lid = f"lid{other_jar(task.world.frame('goal').parent)[-1]}"
    return not task.gripper.grasped and task.world.sensor("table_spot").detects(lid)


def lid_is_up(task: Task) -> bool:
    """Whether the lid of the carton stands up, past its upright position."""
    return task.world.joint("carton/lid_hinge").position < 1.5


def charger_hangs_half_in(task: Task) -> bool:
    """Whether the charger was let go and stays with its pins in their holes."""
    charger, panel = task.world.body("charger").position, task.world.body("panel").position
    return not task.gripper.grasped and bool(charger[2] - panel[2] > 0.13)


def wing_is_latched(task: Task) -> bool:
    """Whether the latch of the window still holds its wing."""
    return task.world.joint("window/wing_hinge").locked


def loose_brick_is_out(task: Task) -> bool:
    """Whether the loose brick was let go outside the tower."""
    return not task.gripper.grasped and not task.world.sensor("around").detects("target")


def all_buttons_are_green(task: Task) -> bool:
    """Whether every button was pressed."""
    return all(task.green)


def push_to_another_square(task: Task) -> None:
    """Push the block to a square that is not asked for."""
    asked = task.world.frame("waypoint0").parent
    task.world.frame("waypoint0").set_parent("blue" if asked == "green" else "green")


def block_is_on_another_square(task: Task) -> bool:
    """Whether the block lies on the middle of a square that is not asked for."""
    return any(task.world.sensor(f"on_{color}").detects("block") for color in task.colors)  # type: ignore[attr-defined]


def sweep_the_other_way(task: Task) -> None:
    """Sweep towards the dustpan that is not asked for."""
    for name in ("waypoint3", "waypoint5"):
        frame = task.world.frame(name)
        frame.set_local([-frame.local[0], *frame.local[1:]])


def crumbs_are_in_the_other_pan(task: Task) -> bool:
    """Whether one dustpan has all crumbs."""
    return any(all(task.world.sensor(f"in_{size}").detects(f"crumb{i}") for i in range(5)) for size in ("tall", "short"))


def press_minus(task: Task) -> None:
    """Press the button for the channel below, where the one above is asked for."""
    task.world.frame("waypoint6").set_parent("remote/minus")


def first_channel_is_on(task: Task) -> bool:
    """Whether the button for the channel below is down."""
    return task.world.joint("remote/minus_joint").position > 0.003


def remote_lies_loose(task: Task) -> bool:
    """Whether the power button is down and nothing is held."""
    return not task.gripper.grasped and task.world.joint("remote/power_joint").position > 0.003


def cube_is_in(drawer: str) -> Callable[[Task], bool]:
    """Return the question whether the cube lies in a drawer, let go."""
    return lambda task: not task.gripper.grasped and task.world.sensor(f"in_{drawer}").detects("cube")


def rack_the_wine_elsewhere(task: Task) -> None:
    """Lay the bottle at the left of the rack, whichever notch is asked for."""
    task.world.frame("waypoint4").set_parent("left")


def wine_is_at_the_left(task: Task) -> bool:
    """Whether the bottle lies at the left of the rack."""
    return task.world.sensor("notch_left").detects("bottle")


def take_the_other_bin(task: Task) -> None:
    """Carry the paper to the bin that is not asked for."""
    task.world.frame("waypoint3").set_parent("blue_bin")


def paper_is_in_the_other_bin(task: Task) -> bool:
    """Whether the paper lies in the blue bin, let go."""
    return not task.gripper.grasped and task.world.sensor("blue_bottom").detects("rubbish")


def use_another_lane(task: Task) -> None:
    """Carry the plate to a lane of the dish rack that is not asked for."""
    frame, goal = task.world.frame("waypoint4"), task.world.sensor("lane")
    frame.set_parent(f"lane{(int(goal.parent[-1]) + 1) % 3}")
    frame.set_local([*frame.local[:2], frame.local[2] + goal.local[2], *frame.local[3:]])


def plate_is_in_another_lane(task: Task) -> bool:
    """Whether the plate was let go in a lane of the dish rack that is not asked for."""
    places = [task.world.frame(f"lane{i}").position for i in range(3)]
    near = [float(np.linalg.norm((place - task.world.body("plate").position)[:2])) < 0.01 for place in places]
    return not task.gripper.grasped and near[int(task.world.sensor("lane").parent[-1]) - 2]


def plate_lies_beside_the_mat(task: Task) -> bool:
    """Whether the plate was let go outside the dish rack."""
    return not task.gripper.grasped and not task.world.sensor("rack_space").detects("plate")


def ball_lies_in_front(task: Task) -> bool:
    """Whether the ball was let go and has fallen to the table in front of the hoop."""
    return not task.gripper.grasped and bool(task.world.body("ball").position[2] - task.world.body("hoop").position[2] < 0.2)


def piece_lies_on_the_others(task: Task) -> bool:
    """Whether the loose piece was let go over the glued ones, not in the gap."""
    height = task.world.body("piece").position[2] - task.world.body("tray").position[2]
    return not task.gripper.grasped and bool(0.01 < height < 0.03)


NO_GRASP = Negative(Omission(grasps=True))
NEGATIVES = {
    "basketball_in_hoop": Negative(spoil=moved("waypoint3", x=-0.14), done=ball_lies_in_front),
    "beat_the_buzz": Negative(spoil=moved("waypoint2", z=0.03), done=holding("wand")),  # the ring touches the rod
    "close_box": Negative(Omission(waypoints=(7,)), done=lid_is_up),  # folded up, not pushed over
    "close_jar": Negative(spoil=close_the_other_jar, done=other_jar_is_shut),
    "close_laptop_lid": Negative(Omission(waypoints=(5,))),  # tipped, not pressed flat
    "close_fridge": Negative(Omission(waypoints=(2,))),
    "close_drawer": Negative(Omission(waypoints=(1,))),
    "close_grill": Negative(Omission(waypoints=(2, 3, 4))),
    "change_channel": Negative(spoil=press_minus, done=first_channel_is_on, variation=0),
    "change_clock": Negative(Omission(waypoints=(2,))),
    "close_door": Negative(Omission(waypoints=(2, 3))),  # the fingers close on the lever and stay
    "close_microwave": Negative(Omission(waypoints=(1,))),
    "get_ice_from_fridge": Negative(Omission(waypoints=(4,)), done=holding("cup")),  # in front of the niche
    "hit_ball_with_queue": Negative(Omission(waypoints=(4,)), done=holding("cue")),
    "hockey": Negative(Omission(waypoints=(4,)), done=holding("stick")),
    "insert_onto_square_peg": Negative(Omission(waypoints=(4,)), done=holding("ring")),  # above the pillar
    "insert_usb_in_computer": Negative(spoil=moved("waypoint4", x=-0.01), done=holding("stick")),  # 8 mm deep
    "lift_numbered_block": Negative(Omission(waypoints=(2,)), done=holding("block2"), variation=1),
    "lamp_off": Negative(Omission(waypoints=(1,))),
    "lamp_on": Negative(Omission(waypoints=(1,))),
    "open_door": Negative(Omission(waypoints=(3, 4))),  # the swing alone also turns the lever, as the gripper slides along it
    "open_jar": Negative(spoil=open_the_other_jar, done=other_lid_is_in_the_ring),
    "open_fridge": Negative(Omission(waypoints=(2, 3, 4, 5))),
    "open_grill": Negative(Omission(waypoints=(2, 3, 4))),
    "open_oven": Negative(Omission(waypoints=(2, 3, 4))),
    "open_washing_machine": Negative(Omission(waypoints=(2, 3, 4))),
    "open_window": Negative(Omission(waypoints=(1, 2, 3, 4)), done=wing_is_latched),  # a push, the handle as it hung
    "open_wine_bottle": Negative(Omission(waypoints=(1,)), pull_without_a_turn),
    "pick_and_lift": Negative(Omission(waypoints=(2, 3)), done=holding("block")),
    "pick_and_lift_small": Negative(Omission(waypoints=(2, 3)), done=holding("star"), variation=3),
    "pick_up_cup": Negative(Omission(waypoints=(2,)), done=holding("cup")),
    "play_jenga": Negative(spoil=moved("waypoint2", x=-0.0459, z=-0.0655), done=loose_brick_is_out),  # upwards: the tower falls
    "place_wine_at_rack_location": Negative(spoil=rack_the_wine_elsewhere, done=wine_is_at_the_left, variation=2),
    "plug_charger_in_power_supply": Negative(spoil=moved("waypoint3", x=-0.006), done=charger_hangs_half_in),
    "press_switch": Negative(spoil=moved("waypoint1", z=-0.05)),  # the lower half, which is in already
    "push_button": Negative(Omission(waypoints=(1,))),
    "push_buttons": Negative(spoil=press_backwards, done=all_buttons_are_green, variation=2),
    "push_buttons4": Negative(spoil=press_backwards, done=all_buttons_are_green, variation=3),
    "put_item_in_drawer": Negative(  # into the drawer below
        spoil=lambda task: task.world.frame("waypoint1").move_to("handle_middle"), done=cube_is_in("middle"), variation=2
    ),
    "put_items_in_drawer": Negative(
        spoil=lambda task: task.world.frame("waypoint1").move_to("handle_middle"), done=cube_is_in("middle"), variation=4
    ),
    "put_plate_in_colored_dish_rack": Negative(spoil=use_another_lane, done=plate_is_in_another_lane),
    "put_knife_in_knife_block": Negative(Omission(waypoints=(4,)), done=holding("knife")),  # in front of the slot
    "put_knife_on_chopping_board": Negative(Omission(waypoints=(3,)), done=holding("knife")),  # above its block
    "put_rubbish_in_color_bin": Negative(spoil=take_the_other_bin, done=paper_is_in_the_other_bin, variation=0),
    "reach_and_drag": Negative(Omission(waypoints=(5,)), done=holding("stick")),
    "reach_target": Negative(spoil=moved("waypoint0", z=0.03), done=tip_is_near_the_ball),
    "scoop_with_spatula": Negative(Omission(waypoints=(2,)), done=holding("spatula")),  # lifted without the cube
    "screw_nail": Negative(Omission(waypoints=(5,)), done=holding("screwdriver")),
    "set_clock_to_time": Negative(spoil=turn_the_hand_too_far, done=it_is_half_past, variation=0),
    "slide_block_to_color_target": Negative(spoil=push_to_another_square, done=block_is_on_another_square),
    "slide_cabinet_open": Negative(Omission(waypoints=(2,))),
    "slide_block_to_target": Negative(Omission(waypoints=(1,))),
    "solve_puzzle": Negative(spoil=moved("waypoint4", x=-0.04, z=0.015), done=piece_lies_on_the_others),
    "sweep_to_dustpan_of_size": Negative(spoil=sweep_the_other_way, done=crumbs_are_in_the_other_pan),
    "take_lid_off_saucepan": Negative(Omission(waypoints=(2,)), done=holding("lid")),
    "take_plate_off_colored_dish_rack": Negative(spoil=moved("waypoint4", y=-0.12), done=plate_lies_beside_the_mat),
    "take_umbrella_out_of_umbrella_stand": Negative(Omission(waypoints=(2,)), done=holding("umbrella")),
    "turn_tap": Negative(spoil=turn_the_left_handle, done=left_handle_is_turned, variation=1),
    "toilet_seat_down": Negative(Omission(waypoints=(1, 2, 3))),  # pressed on where no seat is
    "tv_on": Negative(spoil=moved("waypoint4", y=0.06), done=remote_lies_loose),  # beside the place in front of the television
    "toilet_seat_up": Negative(Omission(waypoints=(4, 5))),  # half way up
    "unplug_charger": Negative(spoil=moved("waypoint1", x=-0.098, z=0.0146), done=holding("charger")),  # the pins stay 4 mm deep
    "water_plants": Negative(spoil=moved("waypoint4", x=-0.04, z=0.02), done=holding("can")),  # tilted beside the plant
}
"""What each task cannot do without, or must not do; grasping where nothing is said.

A task with a base is as that one, unless it says otherwise."""


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_without_its_decisive_action_it_fails(task_env: TaskEnvironment, seed: int) -> None:
    """The script runs as far as it can; the goal is not reached, at no moment of its last segment and not afterwards."""
    name = task_env.get_name()
    negative = NEGATIVES.get(name) or NEGATIVES.get(task_scene(task_class(name)).base or name, NO_GRASP)
    task_env.set_variation(negative.variation)
    task_env.reset(seed=seed)
    negative.spoil(task_env.task)
    cause, _ = try_play(DemoPlayer(task_env.runtime, record=False, omit=negative.omit))
    assert cause, "reached without the decisive action"
    assert task_env.task.success()[0] is False
    assert negative.done(task_env.task), f"it failed for another reason: {cause}"
    task_env.set_variation(0)


@pytest.mark.parametrize("name", NEGATIVES)
def test_the_list_names_tasks_that_exist(name: str) -> None:
    """A renamed task must not lose its negative script."""
    assert task_class(name)
