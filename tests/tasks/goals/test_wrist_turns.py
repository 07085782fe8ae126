"""Handles that a turn of the wrist turns: which one, and how far."""

from __future__ import annotations

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
