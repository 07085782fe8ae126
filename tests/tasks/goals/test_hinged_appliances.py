"""Fridge, grill and washing machine: how far doors and lids have to turn, which ones, and which way."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tasks.goals.goal import Goal, goal_of


@goal_of("close_fridge")
def test_the_fridge_is_shut_by_thirty_degrees(goal: Goal) -> None:
    """The upper door starts at 0.9 rad and stays there; opened further it is not closed, and the lower door is nothing."""
    door = goal.world.joint("fridge/upper_door")
    for _ in range(20):
        goal.world.step()
    assert door.position == pytest.approx(0.9, abs=1e-3)
    assert not goal.reached()
    goal.joint(door.name, door.upper)
    assert not goal.reached()
    goal.joint(door.name, 0.9)
    goal.joint("fridge/lower_door", 0.9)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(door.name, 0.9 - np.deg2rad(angle)), inside=30.2, outside=29.8)
    goal.joint(door.name, 0.0)
    assert goal.reached()
