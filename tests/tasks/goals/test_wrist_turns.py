"""Handles and keys that a turn of the wrist turns: which one, which way, and how far."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks.library.set_clock_to_time import SetClockToTime
from tests.tasks.goals.goal import Goal, goal_of


@goal_of("turn_tap", 0, 1)
def test_the_asked_handle_has_to_turn_by_a_quarter(goal: Goal) -> None:
    """By 1.57 rad either way, and only as long as it stays turned; the other handle does nothing, whatever both add up to."""
    asked = ("left", "right")[goal.asked(("left", "right"))]
    other = "left" if asked == "right" else "right"
    for angle in (3.0, -3.0):
        goal.joint(f"tap/{other}", angle)
        assert not goal.reached()
        goal.joint(f"tap/{asked}", 1.0)
        assert not goal.reached()
        for way in (1.0, -1.0):
            goal.border(lambda turn, way=way: goal.joint(f"tap/{asked}", way * turn), inside=1.575, outside=1.565)
        goal.joint(f"tap/{asked}", 0.0)
        assert not goal.reached()


@goal_of("turn_tap", 0, 1)
def test_left_and_right_are_those_of_a_viewer_before_the_spout(goal: Goal) -> None:
    """The spout points to -x of the tap; the left handle is red and the right one blue, as hot and cold water are."""
    side = ("left", "right")[goal.asked(("left", "right"))]
    handle = goal.world.placement(f"tap/{side}_handle")
    seen_from_the_spout = goal.world.placement("tap").actInv(handle).translation
    assert (seen_from_the_spout[1] > 0.0) == (side == "left")
    goal.joint(f"tap/{side}", 1.6)
    assert goal.reached()


CLOSE = np.deg2rad(10.2)
"""The long hand, 12 mm wide, touches a volume of 15 mm, 76 to 91 mm from the axle, up to about so far from the middle [rad]."""


def check_where_the_hand_counts(goal: Goal, place: float) -> None:
    """Check that the long hand counts up to `CLOSE` from a place of the dial [rad], as far as it can turn, and nowhere else."""
    margin = np.deg2rad(0.3)
    for way in (-1.0, 1.0):
        if abs(place + way * CLOSE) < 4.95:
            goal.border(lambda off, way=way: goal.joint("clock/hand", place + way * off), CLOSE - margin, CLOSE + margin)
    elsewhere = [a for a in np.arange(-3.1, 5.0, 0.05) if abs((a - place + np.pi) % (2.0 * np.pi) - np.pi) > CLOSE + margin]
    for angle in elsewhere:
        goal.joint("clock/hand", angle)
        assert not goal.reached(), angle
    goal.joint("clock/hand", place)
    assert goal.reached()


@goal_of("change_clock")
def test_the_long_hand_has_to_point_at_three(goal: Goal) -> None:
    """Forward, to the right of a viewer in front; not at nine, at one or at two, and passing three does not count for good."""
    for hour in (-3, 1, 2, 4, 6):
        goal.joint("clock/hand", hour * np.pi / 6.0 * 0.999)
        assert not goal.reached(), hour
    check_where_the_hand_counts(goal, np.pi / 2.0)
    seen = goal.world.placement("clock").actInv(goal.world.placement("clock/movement"))
    assert np.allclose(seen.rotation @ [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], atol=1e-6)


@goal_of("set_clock_to_time", 0, 1, 2)
def test_the_long_hand_has_to_point_at_the_asked_time(goal: Goal) -> None:
    """Forward to three, six or nine as the sentence says; the other two times do not count, nor does turning back."""
    numbers = ("quarter_past", "half_past", "quarter_to")
    place = (0.5 * np.pi, np.pi, 1.5 * np.pi)[goal.asked(numbers)]
    assert set(numbers) == set(SetClockToTime.times)
    check_where_the_hand_counts(goal, place)
    goal.joint("clock/hand", place - 2.0 * np.pi)
    assert not goal.reached()
    assert goal.world.joint("clock/hand").position < 0.0
