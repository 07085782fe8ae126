"""A knife that is put into the slot of its block, or laid on a board."""

from __future__ import annotations

import numpy as np

from tests.tasks.goals.goal import Goal, goal_of


@goal_of("put_knife_in_knife_block")
def test_the_blade_has_to_reach_the_bottom_of_the_open_slot(goal: Goal) -> None:
    """Either face up, let go; half-way in, in front of the slot, at a painted one or on the block it does not count."""
    assert not goal.reached()
    for place in ((-0.2, 0.0, 0.0), (-0.12, 0.0, 0.0), (-0.16, 0.022, -0.022), (-0.065, 0.0, 0.055)):
        goal.put("knife", place, on="mouth")
        assert not goal.reached()
    goal.put("knife", (-0.05, 0.0, 0.0), (0.0, 0.0, np.pi), on="mouth")  # the handle first
    assert not goal.reached()
    for roll in (np.pi, 0.0):
        goal.ends("knife", (-0.062, 0.0, 0.0), (roll, 0.0, 0.0), on="mouth", x=(-0.018,))
    goal.needs_release_of("knife")


@goal_of("put_knife_on_chopping_board")
def test_handle_and_blade_have_to_lie_on_the_board(goal: Goal) -> None:
    """Either face up, at any yaw, let go; upright, leaning, beside the board or with the blade alone on it does not count."""
    assert not goal.reached()
    for place, rpy in (
        ((0.0, 0.0, 0.17), (0.0, np.pi / 2.0, 0.0)),  # upright, the point on the board
        ((-0.03, 0.0, 0.045), (0.0, 0.0, 0.0)),  # over the board
        ((-0.15, 0.0, 0.025), (0.0, 0.0, 0.0)),  # the blade alone
        ((0.08, 0.0, 0.025), (0.0, 0.0, 0.0)),  # the handle alone
        ((-0.03, 0.15, 0.01), (0.0, 0.0, 0.0)),  # on the table
    ):
        goal.put("knife", place, rpy, on="board")
        assert not goal.reached()
    goal.put("knife", (0.03, 0.0, 0.025), (np.pi, 0.0, np.pi), on="board")
    assert goal.reached()
    goal.put("knife", (0.0, -0.04, 0.025), (0.0, 0.0, np.pi / 2.0), on="board")
    assert goal.reached()
    goal.border(lambda pitch: goal.put("knife", (-0.03, 0.0, 0.025), (0.0, pitch, 0.0), on="board"), inside=0.1, outside=0.12)
    goal.ends("knife", (-0.03, 0.0, 0.025), on="board", x=(-0.08, 0.05), y=(-0.07, 0.07), z=(-0.01, 0.01))
    goal.needs_release_of("knife")
