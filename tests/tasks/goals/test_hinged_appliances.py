"""Fridge, grill and washing machine: how far doors and lids have to turn, which ones, and which way."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tasks.goals.goal import Goal, goal_of


@goal_of("close_fridge", also=["close_fridge2"])
def test_the_fridge_is_shut_up_to_twenty_two_degrees(goal: Goal) -> None:
    """The upper door starts at 1.7 rad and stays there; opened further it is not closed, and the lower door is nothing."""
    door = goal.world.joint("fridge/upper_door")
    for _ in range(20):
        goal.world.step()
    assert door.position == pytest.approx(1.7, abs=1e-3)
    assert not goal.reached()
    goal.joint(door.name, door.upper)
    assert not goal.reached()
    goal.joint(door.name, 1.7)
    goal.joint("fridge/lower_door", 0.9)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(door.name, np.deg2rad(angle)), inside=21.5, outside=22.0)
    goal.joint(door.name, 0.0)
    assert goal.reached()


@goal_of("open_fridge")
def test_the_upper_door_of_the_fridge_opens_by_seventy_degrees(goal: Goal) -> None:
    """The lower door, however far, is nothing."""
    goal.joint("fridge/lower_door", 1.9)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint("fridge/upper_door", np.deg2rad(angle)), inside=70.2, outside=69.8)


@goal_of("close_grill")
def test_the_hood_comes_down_by_fifty_degrees(goal: Goal) -> None:
    """It starts at 1.2 rad, holds itself there, and is not closed by being opened to its stop."""
    lid = goal.world.joint("grill/lid")
    for _ in range(20):
        goal.world.step()
    assert lid.position == pytest.approx(1.2, abs=1e-3)
    goal.joint(lid.name, lid.upper)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint(lid.name, 1.2 - np.deg2rad(angle)), inside=50.2, outside=49.8)
    goal.joint(lid.name, 0.0)
    assert goal.reached()


@goal_of("open_grill")
def test_the_hood_goes_up_by_fifty_degrees(goal: Goal) -> None:
    """Half open it stays where it is left, though nothing holds it."""
    lid = goal.world.joint("grill/lid")
    goal.border(lambda angle: goal.joint(lid.name, np.deg2rad(angle)), inside=50.2, outside=49.8)
    for _ in range(20):
        goal.world.step()
    assert goal.reached()
    assert lid.position == pytest.approx(np.deg2rad(50.2), abs=2e-3)


@goal_of("open_washing_machine")
def test_the_round_door_swings_by_forty_degrees(goal: Goal) -> None:
    """A door that stands ajar is not open."""
    goal.joint("washing_machine/door", 0.3)
    assert not goal.reached()
    goal.border(lambda angle: goal.joint("washing_machine/door", np.deg2rad(angle)), inside=40.2, outside=39.8)
