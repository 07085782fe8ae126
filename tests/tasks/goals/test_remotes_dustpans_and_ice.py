"""Things that one of several places or buttons is asked for: colours, dustpans, channels; and a cup at an ice dispenser."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.spatial import TABLE_HEIGHT
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import running

DOWN, UP = 0.0032, 0.0028
"""How far a button is down just far enough, and just not [m]; 3 mm are asked."""


@goal_of("slide_block_to_color_target", 0, 1, 2, 3)
def test_the_block_has_to_reach_the_square_of_the_asked_colour(goal: Goal) -> None:
    """Its side within 2 cm of the middle, on the table; on any other square it does not count."""
    asked = goal.task.colors[goal.asked(goal.task.colors)]
    for color in goal.task.colors:
        goal.put("block", (0.0, 0.0, 0.03), on=color)
        assert goal.reached() is (color == asked)
    goal.ends("block", (0.0, 0.0, 0.03), on=asked, x=(-0.05, 0.05), y=(-0.05, 0.05), z=(0.03,))


@goal_of("sweep_to_dustpan_of_size", 0, 1)
def test_all_five_crumbs_have_to_lie_in_the_asked_pan(goal: Goal) -> None:
    """Each of them; not over, beside or behind it, and not in the other one."""
    asked = goal.asked(goal.task.sizes)
    pan, other = (f"{goal.task.sizes[i]}_pan" for i in (asked, 1 - asked))
    for place in (other, pan):
        for i in range(5):
            goal.put(f"crumb{i}", (0.0, 0.03 * (i - 2), 0.01), on=place)
        assert goal.reached() is (place == pan)
    for i in range(5):
        goal.ends(f"crumb{i}", (0.0, 0.0, 0.01), on=pan, x=(-0.056, 0.056), y=(-0.091, 0.091), z=(0.025,))
        goal.put(f"crumb{i}", (0.0, 0.0, 0.01), on=other)
        assert not goal.reached()
        goal.put(f"crumb{i}", (0.0, 0.0, 0.01), on=pan)


def aim(goal: Goal, button: str) -> None:
    """Check where the remote may lie while a button is down, and how far that has to be down."""
    joint = f"remote/{button}_joint"
    goal.joint(joint, DOWN)
    assert not goal.reached(), "the remote lies where it lay"
    goal.ends("remote", (0.0, 0.0, 0.0), x=(-0.03, 0.03), y=(-0.025, 0.025), z=(-0.006, 0.054))
    goal.border(lambda yaw: goal.put("remote", (0.0, 0.0, 0.0), (0.0, 0.0, yaw)), inside=0.315, outside=0.322)
    for rpy in ((0.0, 0.0, np.pi), (np.pi, 0.0, 0.0)):
        goal.put("remote", (0.0, 0.0, 0.0), rpy)
        assert not goal.reached(), "turned away, or on its buttons"
    goal.put("remote", (0.0, 0.0, 0.0))
    goal.needs_release_of("remote")
    goal.border(lambda depth: goal.joint(joint, depth), inside=DOWN, outside=UP)


@goal_of("tv_on")
def test_power_has_to_be_pressed_while_the_remote_lies_aimed(goal: Goal) -> None:
    """The other buttons do nothing; the screen is dark until then, and shows an image from then on."""
    dark = goal.task.television.colors
    goal.put("remote", (0.0, 0.0, 0.0))
    for button in ("plus", "minus"):
        goal.joint(f"remote/{button}_joint", DOWN)
        assert not goal.reached()
    goal.tick()
    assert goal.task.television.colors == dark
    goal.joint("remote/power_joint", DOWN)
    goal.tick()
    shown = goal.task.television.colors
    assert shown != dark
    goal.put("remote", (0.0, 0.16, 0.0))
    aim(goal, "power")
    goal.tick()
    assert goal.task.television.colors == shown


@goal_of("change_channel", 0, 1)
def test_the_asked_button_has_to_be_pressed_while_the_remote_lies_aimed(goal: Goal) -> None:
    """The other buttons do not count; plus shows the third channel and minus the first."""
    asked = goal.asked(goal.task.buttons)
    goal.put("remote", (0.0, 0.0, 0.0))
    screens = []
    for button in goal.task.buttons:
        goal.joint(f"remote/{button}_joint", DOWN)
        assert goal.reached() is (button == goal.task.buttons[asked])
        goal.tick()
        screens.append(goal.task.television.colors)
        goal.joint(f"remote/{button}_joint", 0.0)
    assert screens[0] != screens[1]
    goal.joint("remote/power_joint", DOWN)
    assert not goal.reached()
    goal.put("remote", (0.0, 0.16, 0.0))
    aim(goal, goal.task.buttons[asked])


@pytest.mark.parametrize("name", ["tv_on", "change_channel"])
def test_buttons_of_the_remote_spring_back(name: str) -> None:
    """Its own weight does not press them when it lies upside down."""
    with running(name) as task:
        task.world.body("remote").set_pose([0.25, 0.0, TABLE_HEIGHT + 0.03, 1.0, 0.0, 0.0, 0.0])
        task.world.joint("remote/plus_joint").set_position(0.005)
        for _ in range(60):
            task.world.step()
        assert all(joint.position < 0.003 for joint in task.world.body("remote").joints.values())


@goal_of("get_ice_from_fridge")
def test_the_cup_has_to_push_the_tongue_with_its_mouth_below_the_outlet(goal: Goal) -> None:
    """The tongue by a degree; not below, over, beside or before the niche, nor upside down; held or not."""
    place = np.array([-0.1, 0.0, 0.305])
    goal.put("cup", place)
    assert not goal.reached(), "the tongue hangs"
    goal.joint("fridge/tongue_joint", 0.02)
    goal.ends("cup", place, x=(-0.02, 0.02), y=(-0.04, 0.04), z=(-0.03, 0.03))
    for height in (0.305, 0.45):
        goal.put("cup", (-0.1, 0.0, height), (np.pi, 0.0, 0.0))
        assert not goal.reached(), "upside down"
    goal.put("cup", place)
    goal.counts_while_held("cup")
    goal.border(lambda angle: goal.joint("fridge/tongue_joint", angle), inside=0.0176, outside=0.0173)
