"""The way back of tasks that put something on, in or onto something: taken off, pulled out, or put where it was taken from."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.spatial import pose_at
from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of
from tests.tasks.running import running

LIT = (1.0, 0.91, 0.66)


@goal_of("meat_on_grill", 0, 1)
def test_the_asked_meat_has_to_lie_on_the_grate(goal: Goal) -> None:
    """The grasp goes to it at the same height; only it counts, let go, less than 3 cm over the grate, not beside it or inside."""
    meats = goal.task.meats
    meat, other = meats if goal.says(meats[0]) else meats[::-1]
    grasp = goal.task.get_waypoints()[1].pose
    np.testing.assert_allclose(grasp[:2], goal.world.body(meat).position[:2], atol=1e-9)
    with running("meat_on_grill") as task:
        assert grasp[2] == pytest.approx(task.world.frame("waypoint1").position[2])
    beside = goal.world.body(other).pose
    goal.put(other, (0.0, 0.12, 0.161))
    assert not goal.reached()
    goal.world.body(other).set_pose(beside)
    low, high = goal.world.body(meat).bounds()
    for place in ((0.0, -0.01 - high[1], -low[2]), (0.0, 0.25 - low[1], -low[2]), (0.0, 0.12, 0.03)):
        goal.put(meat, place)
        assert not goal.reached()
    (left, back), (right, front) = low[:2] - [0.15, 0.1], high[:2] + [0.15, 0.1]
    goal.ends(meat, (0.0, 0.12, 0.14 - low[2]), x=(left, right), y=(back, front), z=(0.03,))
    goal.needs_release_of(meat)


@goal_of("unplug_charger")
def test_the_pins_of_the_charger_have_to_be_out_of_the_wall(goal: Goal) -> None:
    """In front of the socket, held or not; on the table, plugged in or with its pins a little in the holes it does not count."""
    for depth in (0.018, 0.001):
        for pitch, yaw in ((0.0, 0.0), (-0.148, 0.0), (0.13, 0.18)):
            pin = 0.043 * np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), -np.sin(pitch)])
            goal.put("charger", np.array([depth - 0.008, 0.0, 0.15]) - pin, (0.0, pitch, yaw), on="panel")
            assert not goal.reached()
    goal.put("charger", (-0.135, 0.0, 0.02), on="panel")
    assert not goal.reached()
    borders = {"x": (-0.093, 0.075), "y": (-0.0525, 0.0525), "z": (-0.07, 0.07)}
    goal.ends("charger", (-0.135, 0.0, 0.15), on="panel", **borders)
    goal.counts_while_held("charger")


@goal_of("take_off_weighing_scales", 0, 1, 2)
def test_the_asked_pepper_has_to_lie_before_the_scales(goal: Goal) -> None:
    """Let go, less than 6 cm over the table; on the tray, behind the scales, or another pepper does not count."""
    asked = goal.world.body(f"pepper_{goal.task.colors[goal.asked(goal.task.colors)]}").name
    for other in {pepper.name for pepper in goal.task.peppers} - {asked}:
        on_tray = goal.world.body(other).pose
        goal.put(other, (-0.14, 0.0, 0.035))
        assert not goal.reached()
        goal.world.body(other).set_pose(on_tray)
    for place in ((0.1, 0.0, 0.2), (0.3, 0.0, 0.035), (0.1, 0.2, 0.035)):
        goal.put(asked, place)
        assert not goal.reached()
    goal.ends(asked, (-0.14, 0.0, 0.035), x=(-0.153, 0.153), y=(-0.153, 0.153), z=(0.06,))
    goal.needs_release_of(asked)


@goal_of("take_off_weighing_scales", 0, 1, 2)
def test_the_hand_comes_down_on_the_asked_pepper_and_the_needle_turns(goal: Goal) -> None:
    """15 cm over it, as specified; each pepper turns the needle by 130 rad for each metre by which the tray sinks."""
    asked = f"pepper_{goal.task.colors[goal.asked(goal.task.colors)]}"
    above = goal.task.get_waypoints()[0].pose
    np.testing.assert_allclose(above[:3], goal.world.body(asked).position + [0.0, 0.0, 0.152], atol=1e-6)
    needle, sinks = goal.world.joint("scales/needle"), 0.15 * 9.81 / 180.0
    for count in (3, 2, 1, 0):
        assert needle.position == pytest.approx(-130.0 * sinks * count, abs=0.02)
        goal.joint("scales/tray", 0.004 + sinks * max(count - 1, 0))
        goal.tick()
    goal.put(asked, (-0.14, 0.0, 0.035))
    assert goal.reached()


@goal_of("light_bulb_out", 0, 7, 10, 19)
def test_the_bulb_has_to_stand_in_the_asked_holder(goal: Goal) -> None:
    """At its bottom, upright, let go; it glows in the lamp alone. In the other holder, on a rim or beside one it does not."""
    rgb = COLORS[goal.asked([color.name for color in COLORS])].rgb
    holder, other = sorted(("holder0", "holder1"), key=lambda name: goal.world.body(name).color[:3] != rgb)
    assert goal.world.body(other).color[:3] != rgb
    assert glows(goal)
    seat = (0.0, 0.0, 0.004 + 0.076)
    for place, on in ((seat, other), ((0.0, 0.0, 0.034 + 0.076), holder), ((0.05, 0.0, 0.076), holder)):
        goal.put("bulb", place, on=on)
        goal.tick()
        assert not goal.reached()
        assert not glows(goal)
    goal.ends("bulb", seat, on=holder, x=(-0.018, 0.018), y=(-0.018, 0.018), z=(0.0085,))
    goal.border(lambda tilt: goal.put("bulb", seat, (tilt, 0.0, 0.0), on=holder), inside=0.26, outside=0.27)
    goal.put("bulb", seat, on=holder)
    goal.needs_release_of("bulb")
    goal.tick()
    assert not glows(goal)
    goal.task.cleanup()
    assert glows(goal)


def glows(goal: Goal) -> bool:
    """Whether the glass of the bulb shines."""
    return LIT in (color[:3] for color in goal.world.body("bulb").colors.values())


@goal_of("light_bulb_out", 0, 10, 19)
def test_the_hand_is_turned_alike_wherever_the_task_stands(goal: Goal) -> None:
    """Straight down on the bulb, and by 0.3735 rad over the holder, as specified."""
    goal.world.place_root(pose_at((0.3, 0.1, goal.world.root.pose[2]), 0.0, 0.0, 1.0))
    goal.task.get_waypoints()[0].run_start_hook()
    for number, turn in ((1, np.pi), (4, 0.3735)):
        pose = goal.task.get_waypoints()[number].pose
        np.testing.assert_allclose(np.abs(pose[3:] @ pose_at((0.0, 0.0, 0.0), np.pi, 0.0, turn)[3:]), 1.0, atol=1e-6)
    goal.put("bulb", goal.task.get_waypoints()[4].pose[:3] - [0.0, 0.0, 0.0105], on="world")
    assert goal.reached()


@goal_of("take_frame_off_hanger")
def test_the_frame_has_to_lie_before_the_wall(goal: Goal) -> None:
    """Let go, whichever face is up; on the hook, in the air, on an edge, leaning, close to the wall or behind it do not count."""
    flat = (0.0, np.pi / 2.0, 0.0)
    goal.put("frame", (-0.25, 0.0, 0.0285), flat, on="wall")
    assert not goal.reached(), "it was never held"
    assert goal.task.gripper.grasp("frame")
    assert not goal.reached()
    goal.task.gripper.release()
    assert goal.reached()
    for place in ((-0.0405, 0.0, 0.351), (-0.25, 0.0, 0.351), (-0.25, 0.0, 0.139), (-0.25, 0.0, 0.0755), (0.2, 0.0, 0.0755)):
        goal.put("frame", place, on="wall")
        assert not goal.reached()
    for place, rpy in (
        ((-0.25, 0.0, 0.1005), (np.pi / 2.0, 0.0, 0.0)),  # on a short edge
        ((-0.05, 0.0, 0.075), (0.0, 0.5, 0.0)),  # leaning on the wall
        ((-0.15, 0.0, 0.05), (0.0, 1.2, 0.0)),  # one edge up by 5 cm
        ((-0.25, 0.0, 0.06), flat),  # flat in the air
    ):
        goal.put("frame", place, rpy, on="wall")
        assert not goal.reached()
    goal.ends("frame", (-0.25, 0.0, 0.0285), flat, on="wall", x=(-0.2, 0.155), y=(-0.275, 0.275), z=(0.009,))
    goal.needs_release_of("frame")
    goal.put("frame", (-0.25, 0.0, 0.0085), (0.0, -np.pi / 2.0, 0.0), on="wall")
    assert goal.reached()
