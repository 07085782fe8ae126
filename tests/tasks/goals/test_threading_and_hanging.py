"""Hangers on rails, and rolls on the arm of a stand."""

from __future__ import annotations

import numpy as np

from tests.tasks.goals.goal import Goal, goal_of

HUNG = 0.3345
"""Height of the middle of the hook when the hanger hangs on a rail [m]."""
THREADED = (0.0525, 0.0, 0.1635)
"""Middle of the roll when it hangs on the arm, in the axes of the stand [m]."""


def hanger_has_to_hang(goal: Goal, rail: str) -> None:
    """Check that the hanger has to hang on a rail by its hook, anywhere along it, and let go."""
    hung = (0.0, 0.0, HUNG)
    goal.ends("hanger", hung, on=rail, x=(-0.203, 0.203), y=(-0.008, 0.008), z=(-0.005, 0.005))
    goal.needs_release_of("hanger")
    goal.border(lambda tilt: goal.put("hanger", hung, (tilt, 0.0, 0.0), on=rail), inside=0.39, outside=0.41)
    for rpy in ((0.0, 0.0, np.pi), (0.0, 0.0, 0.4)):
        goal.put("hanger", hung, rpy, on=rail)
        assert goal.reached()
    for place, rpy in (
        ((0.0, 0.0, 0.371), (np.pi, 0.0, 0.0)),  # upside down
        ((0.0, -0.03, 0.36), (0.0, 0.0, 0.0)),  # beside the rail
        ((0.0, 0.02, 0.42), (0.0, 0.0, 0.0)),  # its shoulder on the rail
        ((0.0, 0.0, 0.353), (0.0, np.pi / 2.0, 0.0)),  # flat on the rail
        ((0.0, 0.0, 0.122), (0.0, 0.0, 0.0)),  # under the rail, on the table
    ):
        goal.put("hanger", place, rpy, on=rail)
        assert not goal.reached(), (place, rpy)


@goal_of("move_hanger")
def test_the_hanger_has_to_hang_on_the_second_rail(goal: Goal) -> None:
    """By its hook, let go; on the first rail it does not count."""
    for x in (-0.2, 0.0, 0.2):
        goal.put("hanger", (x, 0.0, HUNG), on="first_rail")
        assert not goal.reached()
    hanger_has_to_hang(goal, "second_rail")


@goal_of("place_hanger_on_rack")
def test_the_hanger_has_to_hang_on_the_rack(goal: Goal) -> None:
    """By its hook, let go; in its stand it does not count."""
    hanger_has_to_hang(goal, "rack")


@goal_of("put_toilet_roll_on_stand")
def test_the_roll_has_to_be_on_the_arm_up_to_the_post(goal: Goal) -> None:
    """Either end first, let go; half-way on, on top of the arm, beside it, or at the foot of the stand it does not count."""
    goal.ends("roll", THREADED, on="stand", x=(-0.0075, 0.0195), y=(-0.012, 0.012), z=(-0.0055, 0.0185))
    goal.needs_release_of("roll")
    goal.border(lambda tilt: goal.put("roll", THREADED, (0.0, tilt, 0.0), on="stand"), inside=0.115, outside=0.13)
    goal.border(lambda yaw: goal.put("roll", THREADED, (0.0, 0.0, yaw), on="stand"), inside=0.26, outside=0.28)
    for rpy in ((0.0, 0.0, np.pi), (1.0, 0.0, 0.0)):
        goal.put("roll", THREADED, rpy, on="stand")
        assert goal.reached()
    for place, rpy in (
        ((0.09, 0.0, 0.1625), (0.0, 0.0, 0.0)),  # half-way
        ((0.0525, 0.0, 0.215), (0.0, 0.0, 0.0)),  # on top
        ((0.0525, 0.045, 0.17), (0.0, 0.0, 0.0)),  # beside it
        ((0.05, 0.0, 0.225), (0.0, np.pi / 2.0, 0.0)),  # upright on the arm
        ((0.05, 0.0, 0.05), (0.0, 0.0, 0.0)),  # on the foot
        ((0.0, 0.0, 0.23), (0.0, np.pi / 2.0, 0.0)),  # over the post
    ):
        goal.put("roll", place, rpy, on="stand")
        assert not goal.reached(), (place, rpy)


@goal_of("take_toilet_roll_off_stand")
def test_the_roll_has_to_be_held_and_off_the_arm(goal: Goal) -> None:
    """Wherever else it is, and whether it is still held or not; knocked off, or still partly on the arm, it does not count."""
    goal.put("roll", (0.2, 0.0, 0.035), on="stand")
    assert not goal.reached()
    goal.put("roll", (0.056, 0.0, 0.1625), on="stand")
    assert goal.task.gripper.grasp("roll")
    assert not goal.reached()
    goal.task.gripper.release()
    goal.border(lambda x: goal.put("roll", (x, 0.0, 0.1625), on="stand"), inside=0.176, outside=0.174)
    for side in (-1.0, 1.0):
        goal.border(lambda y, s=side: goal.put("roll", (0.06, s * y, 0.17), on="stand"), inside=0.066, outside=0.064)
        goal.border(lambda z, s=side: goal.put("roll", (0.06, 0.0, 0.17 + s * z), on="stand"), inside=0.066, outside=0.064)
    goal.put("roll", (0.2, 0.0, 0.035), on="stand")
    goal.counts_while_held("roll")
