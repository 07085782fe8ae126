"""Buttons that are pressed, a screw and a cap that are turned: how far, and in which order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from rlbench_pin.tasks import BUTTON_COLORS
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import begin, colors, running

DOWN = 0.0032
"""A cap that is just far enough down [m]; 3 mm are asked."""


@goal_of("push_button", 0, 9, 17)
def test_a_press_of_three_millimetres_counts_for_good(goal: Goal) -> None:
    """Then the cap turns green, and the goal stays reached when it has come up again."""
    variation = goal.asked([color.name for color in BUTTON_COLORS])
    assert colors(goal.task, "button") == [BUTTON_COLORS[variation].rgb]
    goal.joint("button/cap_joint", 0.0028)
    goal.tick()
    assert not goal.reached()
    assert not goal.task.is_green
    goal.joint("button/cap_joint", DOWN)
    goal.tick()
    assert goal.task.is_green
    goal.joint("button/cap_joint", 0.0)
    assert goal.reached()


def test_the_button_springs_back() -> None:
    """A pressed cap comes up by itself."""
    with running("push_button") as task:
        begin(task)
        cap = task.world.joint("button/cap_joint")
        cap.set_position(0.006)
        for _ in range(10):
            task.world.step()
        assert cap.position < 0.001


def press(goal: Goal, *buttons: int, depth: float = DOWN) -> bool:
    """Press buttons one after another and let each come up; say whether the goal is reached then."""
    for button in buttons:
        for value in (depth, 0.0):
            goal.joint(f"button{button}/cap_joint", value)
            goal.tick()
            goal.task.success()  # as after every control tick
    return goal.reached()


@goal_of("push_buttons", 0, 24, 48)
def test_one_button_is_asked(goal: Goal) -> None:
    """The others do nothing, a shallow press neither."""
    assert not press(goal, 1, 2)
    assert not press(goal, 0, depth=0.0028)
    assert goal.task.green == [False, True, True]
    assert press(goal, 0)


@goal_of("push_buttons", 1, 25, 49)
def test_two_buttons_are_asked_in_their_order(goal: Goal) -> None:
    """The second before the first does not count; pressed again after it, it does."""
    assert not press(goal, 1, 0)
    assert not press(goal, 2, 0)
    assert press(goal, 1)


@goal_of("push_buttons", 2, 26, 47)
def test_three_buttons_are_asked_in_their_order(goal: Goal) -> None:
    """Neither backwards nor with the last two swapped."""
    orders: Sequence[tuple[int, ...]] = ((2, 1, 0), (0, 2, 1), (1, 2, 0), (0, 1))
    for order in orders:
        goal.task.reset_conditions()
        assert not press(goal, *order), order
    assert press(goal, 2)


@goal_of("push_buttons4", 0, 1, 6, 11, 15)
def test_up_to_four_buttons_are_asked_in_their_order(goal: Goal) -> None:
    """The instruction names their colours in that order; neither one less, nor backwards, nor shallow presses count."""
    names = [color.name for color in BUTTON_COLORS if goal.says(color.name)]
    count = len(names)
    palette = {color.rgb: color.name for color in BUTTON_COLORS}
    asked = [palette[color] for color in colors(goal.task, *(f"button{i}" for i in range(count)))]
    assert sorted(asked) == sorted(names)
    assert [goal.says(f"{a}_button") for a in asked].index(True) == 0
    assert all(goal.says(f"then_the_{a}_one") for a in asked[1:])
    assert not press(goal, *range(count - 1), *range(count, 4))
    goal.task.reset_conditions()
    assert not press(goal, *range(count), depth=0.0028)
    if count > 1:
        assert not press(goal, *reversed(range(count)))
    goal.task.reset_conditions()
    assert press(goal, *range(count))


@goal_of("screw_nail")
def test_the_screw_has_to_turn_while_the_driver_was_taken(goal: Goal) -> None:
    """By 1.4 rad, either way, from where it is when the driver is first held; what was turned before does not count."""
    goal.joint("block/screw", 1.5)
    goal.tick()
    assert not goal.reached()
    assert goal.task.gripper.grasp("screwdriver")
    goal.tick()
    assert not goal.reached()
    for way in (1.0, -1.0):
        goal.task.reset_conditions()
        goal.joint("block/screw", way * 1.5)
        goal.tick()
        assert not goal.reached()
        goal.joint("block/screw", way * (1.5 - 1.39))
        assert not goal.reached()
        goal.joint("block/screw", way * (1.5 - 1.41))
        assert goal.reached()
    goal.task.gripper.release()
    assert goal.reached()


@goal_of("open_wine_bottle")
def test_the_cap_has_to_leave_the_neck(goal: Goal) -> None:
    """Its lower edge above the rim, or all of it beside the neck; a turn alone or a cap that is only raised is not enough."""
    goal.joint("cap/turn", 3.0)
    assert not goal.reached()
    goal.border(lambda height: goal.joint("cap/lift", height), inside=0.029, outside=0.028)
    goal.joint("cap/lift", 0.0)
    for way in ("shift_x", "shift_y"):
        goal.border(lambda shift, way=way: goal.joint(f"cap/{way}", shift), inside=0.034, outside=0.033)
        goal.joint(f"cap/{way}", 0.0)
        assert not goal.reached()


@goal_of("open_wine_bottle")
def test_the_thread_holds_until_it_is_unscrewed(goal: Goal) -> None:
    """149.8 degrees do not free the cap, nor 170 the wrong way, 150.2 anticlockwise do; it stays free."""
    held = [goal.world.joint(f"cap/{name}") for name in ("lift", "shift_x", "shift_y", "roll", "pitch")]
    for angle, locked in ((149.8, True), (-170.0, True), (150.2, False), (0.0, False)):
        goal.joint("cap/turn", np.deg2rad(angle))
        goal.tick()
        assert [joint.locked for joint in held] == [locked] * 5
        assert not goal.reached()
    goal.joint("cap/lift", 0.1)
    assert goal.reached()


@goal_of("press_switch")
def test_the_lamp_on_the_back_follows_the_switch(goal: Goal) -> None:
    """Dark at the start, bright once the rocker is over, and dark again."""
    panel, rocker = goal.world.body("panel"), goal.world.joint("panel/rocker_joint")
    lamp = panel.model.link_index("lamp")
    dark = panel.colors[lamp]
    for value, bright in ((rocker.upper, True), (rocker.lower, False)):
        goal.joint("panel/rocker_joint", value)
        goal.tick()
        assert (panel.colors[lamp] != dark) is bright
    goal.joint("panel/rocker_joint", rocker.upper)
    assert goal.reached()
    goal.joint("panel/rocker_joint", rocker.lower)
    assert not goal.reached()


@goal_of("press_switch")
def test_the_rocker_has_to_turn_to_its_other_end(goal: Goal) -> None:
    """By more than 1 rad, and to stay there: half way over does not count, nor does tipping back."""
    rocker = goal.world.joint("panel/rocker_joint")
    assert rocker.position == pytest.approx(rocker.lower, abs=1e-3)
    for value in (-0.3, 0.0, 0.39):
        goal.joint("panel/rocker_joint", value)
        assert not goal.reached()
    goal.border(lambda value: goal.joint("panel/rocker_joint", value), inside=0.402, outside=0.398)
    goal.joint("panel/rocker_joint", rocker.upper)
    assert goal.reached()
    goal.joint("panel/rocker_joint", rocker.lower)
    assert not goal.reached()


@pytest.mark.parametrize("start", [-0.3, -0.05, 0.05, 0.3])
def test_the_rocker_rests_at_its_ends_alone(start: float) -> None:
    """Let go on either side of the middle it falls to the end of that side within half a second."""
    with running("press_switch") as task:
        begin(task)
        rocker = task.world.joint("panel/rocker_joint")
        rocker.set_position(start)
        for _ in range(10):
            task.world.step()
        assert rocker.position == pytest.approx(np.copysign(0.6, start), abs=0.01)
