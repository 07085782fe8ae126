"""A door that is shut: how far, and which way."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.spatial import compose, relative
from rlbench_pin.urdf import read_urdf
from tests.tasks.goals.goal import Goal, goal_of


@goal_of("close_door")
def test_the_door_has_to_swing_back_by_twenty_five_degrees(goal: Goal) -> None:
    """From 0.6 rad, where it stays until it is pulled; it cannot open by as much, and the lever is nothing."""
    leaf = goal.world.joint("door/leaf_hinge")
    for _ in range(20):
        goal.world.step()
    assert leaf.position == pytest.approx(0.6, abs=1e-3)
    goal.joint("door/lever", 0.8)
    assert not goal.reached()
    goal.joint("door/lever", 0.0)
    for angle in (leaf.upper, 0.45, 0.3):
        goal.joint(leaf.name, angle)
        assert not goal.reached()
    goal.border(lambda angle: goal.joint(leaf.name, 0.6 - np.deg2rad(angle)), inside=25.2, outside=24.8)
    goal.joint(leaf.name, 0.0)
    assert goal.reached()


@goal_of("close_door")
def test_the_stop_meets_the_leaf_where_its_travel_ends(goal: Goal) -> None:
    """It touches the back of the leaf that is open by 0.9 rad, and is 8 cm behind it at the start."""
    frame = next(link for link in read_urdf(goal.world.body("door").model.urdf).links if link.name == "frame")
    (stop,) = (shape for shape in frame.collisions if shape.kind == "cylinder")
    assert stop.origin
    center = compose(goal.place_of("door"), [*stop.origin.xyz, 0.0, 0.0, 0.0, 1.0])
    for angle, gap in ((0.9, 0.0), (0.6, 0.08)):
        goal.joint("door/leaf_hinge", angle)
        assert relative(center, goal.place_of("door/leaf"))[0] - stop.size[0] == pytest.approx(gap, abs=0.005)
        assert not goal.reached()
    goal.joint("door/leaf_hinge", 0.0)
    assert goal.reached()
