"""Slots little wider than what goes into them and comes out: a memory stick and a plate."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS
from tests.tasks.goals.goal import Goal, goal_of

HOME = (-0.0175, 0.0, 0.12)
"""Middle of the stick that is pushed home, in the axes of the computer [m]."""
ON_EDGE = (np.pi / 2.0, 0.0, np.pi / 2.0)
"""How a plate stands in a lane [rad]."""
REST = 0.0925
"""Height of its middle there [m]."""


@goal_of("insert_usb_in_computer")
def test_the_tip_of_the_stick_has_to_reach_the_rear_of_the_port(goal: Goal) -> None:
    """From 12 mm deep on, either side up, held or not; in front of the port, beside it or backwards it does not count."""
    for place, rpy in (
        ((-0.0355, 0.0, 0.12), (0.0, 0.0, 0.0)),  # in front
        ((-0.0175, 0.0, 0.12), (0.0, 0.0, np.pi)),  # backwards
        ((-0.0355, 0.0, 0.14), (0.0, 0.0, 0.0)),  # over the port
        ((-0.01, 0.0, 0.25 + 0.006), (0.0, 0.0, 0.0)),  # on top
        ((-0.028, 0.0, 0.12), (0.0, 0.0, 0.15)),  # turned, its tip half in
        ((-0.028, 0.0, 0.12), (0.0, 0.15, 0.0)),  # tilted, its tip half in
    ):
        goal.put("stick", place, rpy, on="computer")
        assert not goal.reached()
    for roll in (np.pi, 0.0):
        goal.ends(
            "stick", HOME, (roll, 0.0, 0.0), on="computer", within=2e-4, x=(-0.006,), y=(-0.0095, 0.0095), z=(-0.005, 0.005)
        )
    goal.counts_while_held("stick")


@goal_of("take_usb_out_of_computer")
def test_the_stick_has_to_be_out_of_the_port(goal: Goal) -> None:
    """Its tip 1 cm in front of the computer, let go; half way out, straight or askew, it does not count."""
    for depth in (0.018, 0.009, 0.001):
        for tilt in (0.0, 0.1):
            tip = 0.0355 * np.array([np.cos(tilt), 0.0, np.sin(tilt)])
            goal.put("stick", np.array([depth, 0.0, 0.12]) - tip, (0.0, -tilt, 0.0), on="computer")
            assert not goal.reached()
    goal.ends("stick", (-0.1, 0.0, 0.12), on="computer", within=2e-4, x=(0.0545,))
    goal.ends("stick", (-0.0175, 0.05, 0.12), on="computer", within=2e-4, y=(-0.03,))
    goal.put("stick", (-0.1, 0.0, 0.006), on="computer")
    goal.needs_release_of("stick")


@goal_of("put_plate_in_colored_dish_rack", 0, 10, 19)
def test_the_plate_has_to_stand_in_the_asked_lane(goal: Goal) -> None:
    """Low between its pegs, either side in front, let go; in another lane, on the pegs or beside the rack it does not count."""
    rgb = COLORS[goal.asked([color.name for color in COLORS])].rgb
    rack = goal.world.body("rack")
    shown = [tuple(rack.colors[rack.model.link_index(f"lane{i}")][:3]) for i in range(3)]
    assert len(set(shown)) == 3
    lane = shown.index(rgb)
    for other in {0, 1, 2} - {lane}:
        goal.put("plate", (0.0, 0.0, REST), ON_EDGE, on=f"lane{other}")
        assert not goal.reached()
    for place, rpy in (
        ((0.0, 0.0, 0.11 + 0.006), (0.0, 0.0, 0.0)),  # flat on the pegs
        ((0.0, 0.16, 0.08), ON_EDGE),  # beside the rack
        ((0.0, 0.0, 0.2), ON_EDGE),  # over the pegs
        ((0.0, 0.0, 0.11 + 0.08), ON_EDGE),  # on edge on the pegs
    ):
        goal.put("plate", place, rpy, on=f"lane{lane}")
        assert not goal.reached()
    for yaw in (-np.pi / 2.0, np.pi / 2.0):
        rpy = (np.pi / 2.0, 0.0, yaw)
        goal.ends("plate", (0.0, 0.0, REST), rpy, on=f"lane{lane}", x=(-0.01, 0.01), y=(-0.064, 0.064), z=(0.0105,))
    goal.needs_release_of("plate")


@goal_of("put_plate_in_colored_dish_rack")
def test_a_plate_that_is_taken_out_of_the_lane_again_does_not_count(goal: Goal) -> None:
    """In the lane while it is held, then let go elsewhere."""
    lane = goal.world.sensor("lane").parent
    goal.put("plate", (0.0, 0.0, REST), ON_EDGE, on=lane)
    assert goal.task.gripper.grasp("plate")
    assert not goal.reached()
    goal.put("plate", (0.0, 0.2, REST), ON_EDGE, on=lane)
    goal.task.gripper.release()
    assert not goal.reached()
    goal.put("plate", (0.0, 0.0, REST), ON_EDGE, on=lane)
    assert goal.reached()


@goal_of("take_plate_off_colored_dish_rack", 0, 1, 2)
def test_the_plate_has_to_lie_on_the_mat(goal: Goal) -> None:
    """Flat, its middle over the middle of the mat, either side up, let go; in the rack, on edge or leaning it does not count."""
    asked = goal.asked(goal.task.colors)
    np.testing.assert_allclose(goal.world.body("plate").position[:2], goal.world.frame(f"lane{asked}").position[:2], atol=1e-9)
    np.testing.assert_allclose(goal.task.get_waypoints()[1].pose[:2], goal.world.body("plate").position[:2], atol=1e-6)
    for place, rpy, on in (
        ((0.0, 0.0, 0.08), ON_EDGE, "mat"),
        ((0.0, 0.0, 0.05), (0.0, 0.6, 0.0), "mat"),  # leaning on a finger
        ((0.0, 0.0, 0.15), (0.0, 0.0, 0.0), "mat"),  # in the air
        ((0.12, 0.0, 0.006), (0.0, 0.0, 0.0), "mat"),  # half beside it
        ((0.0, 0.0, 0.117), (0.0, 0.0, 0.0), "rack"),  # flat on the pegs
        ((0.0, 0.13, 0.006), (0.0, 0.0, 0.0), "rack"),  # beside the rack
    ):
        goal.put("plate", place, rpy, on=on)
        assert not goal.reached()
    for roll in (np.pi, 0.0):
        goal.ends("plate", (0.0, 0.0, 0.006), (roll, 0.0, 0.0), on="mat", x=(-0.06, 0.06), y=(-0.06, 0.06), z=(0.014,))
    goal.needs_release_of("plate")
