"""Proof that motions are free between the samples too."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.planning.path import along
from rlbench_pin.planning.planner import MotionPlanner, PlannerConfig
from rlbench_pin.planning.proof import ArmShapes, certify
from rlbench_pin.planning.proof.shapes import Shapes
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray
from tests.worlds_for_tests import HOME, Boxes


def judge(model: RobotModel, world: WorldSnapshot) -> CollisionModel:
    """A collision model with no clearance."""
    collision = CollisionModel(model)
    collision.update(world)
    return collision


def reach(collision: CollisionModel) -> FloatArray:
    """How far anything that the arm carries can get from the axis of each joint (n,), [m]."""
    return Shapes(ArmShapes(collision.model), collision).reaches.max(axis=0)


def test_no_point_moves_farther_than_its_bound(model: RobotModel, boxes: Boxes) -> None:
    """The reach of each joint bounds how far the tip can move when the joint turns."""
    reaches = reach(judge(model, boxes.snapshot()))
    rng = np.random.default_rng(0)
    for q in rng.uniform(model.limits.lower, model.limits.upper, (200, 7)):
        turn = rng.uniform(-0.3, 0.3, 7)
        moved = np.linalg.norm(model.tip_pose(q + turn)[:3] - model.tip_pose(q)[:3])
        assert moved <= reaches @ np.abs(turn)


def test_a_held_stick_lengthens_the_reach(model: RobotModel, boxes: Boxes) -> None:
    """What the hand carries swings too."""
    stick = boxes.box("stick", (0.02, 0.02, 0.6), model.tip_pose(HOME)[:3])
    free, held = judge(model, boxes.snapshot(stick)), judge(model, boxes.snapshot(stick, attached=("stick",)))
    assert np.all(reach(held) > reach(free) + 0.1)


def test_keeping_away_is_a_distance(model: RobotModel, boxes: Boxes) -> None:
    """A configuration keeps away by what `distances` measures, whatever was asked before."""
    collision = judge(model, boxes.snapshot(boxes.screen(), *boxes.cubes(4)))
    for q in np.random.default_rng(1).uniform(model.limits.lower, model.limits.upper, (150, 7)):
        nearest = collision.distances(q)[0].distance
        for level in (0.002, 0.03, 0.1):
            if abs(nearest - level) > 1e-4:
                assert collision.keeps_away(q, level) == (nearest > level)


@pytest.mark.parametrize("offset", [0.0, 0.01, 0.017])
def test_a_needle_between_the_samples_is_found(model: RobotModel, boxes: Boxes, offset: float) -> None:
    """A thin post that samples may step over is never certified."""
    tip = model.tip_pose(HOME + [0.3 + offset, 0, 0, 0, 0, 0, 0])[:3]
    world = boxes.snapshot(boxes.box("needle", (0.0005, 0.0005, 0.5), tip))
    collision = judge(model, world)
    collision.begin(HOME)
    path = along(np.array([HOME, HOME + [0.8, 0, 0, 0, 0, 0, 0]]), 1.0)
    assert certify(path, collision).doubt is not None


def test_a_clear_way_is_certified_with_few_checks(model: RobotModel, boxes: Boxes) -> None:
    """Far from everything, few configurations prove a long way."""
    collision = judge(model, boxes.snapshot())
    collision.begin(HOME)
    proof = certify(along(np.array([HOME, HOME + [1.0, 0, 0, 0, 0, 0, 0]]), 1.0), collision)
    assert proof.doubt is None
    assert proof.checks < 200


def test_certified_plans_touch_nothing_anywhere(model: RobotModel, boxes: Boxes) -> None:
    """Accepted motions are looked at every 2e-3 rad; the report says that they were proven."""
    world = boxes.snapshot(boxes.screen(), *boxes.cubes(5))
    planner, collision = MotionPlanner(model), judge(model, world)
    planner.update(world)
    for seed in range(3):
        plan = planner.plan_to_configuration(
            HOME - [0.8, 0, 0, 0, 0, 0, 0], HOME + [0.8, 0, 0, 0, 0, 0, 0], rng=np.random.default_rng(seed)
        )
        assert plan.report.certified
        q = plan.trajectory.q
        steps = max(1, int(np.abs(np.diff(q, axis=0)).max() / 2e-3))
        for a, b in zip(q[:-1], q[1:], strict=True):
            assert not any(collision.in_collision(a + k / steps * (b - a)) for k in range(steps))


def test_the_proof_can_be_left_out(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """`certify=False` saves checks, and says so."""
    planner = MotionPlanner(model, PlannerConfig(certify=False))
    planner.update(boxes.snapshot())
    assert not planner.plan_to_configuration(HOME, HOME + 0.2, rng=rng).report.certified
