"""Sets of goals."""

from __future__ import annotations

import numpy as np

from rlbench_pin.planning.kinematics.goals import PoseRegion, self_motions, symmetric_poses
from rlbench_pin.planning.planner import MotionPlanner, PlannerConfig
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import pose_at, rotation_distance
from tests.worlds_for_tests import HOME, TABLE_TOP, Boxes

DOWN = pose_at((0.35, 0.2, TABLE_TOP + 0.2), np.pi, 0.0, np.pi)


def test_symmetric_poses_turn_about_the_tip() -> None:
    """Four poses at one place, a quarter turn apart."""
    poses = symmetric_poses(DOWN, 4)
    assert len(poses) == 4
    assert all(np.allclose(p[:3], DOWN[:3]) for p in poses)
    np.testing.assert_allclose([rotation_distance(DOWN, p) for p in poses], [0.0, np.pi / 2, np.pi, np.pi / 2], atol=1e-6)


def test_the_elbow_moves_and_the_tip_does_not(model: RobotModel) -> None:
    """Self motions hold the pose."""
    found = self_motions(model, HOME)
    assert len(found) >= 4
    for q in found:
        np.testing.assert_allclose(model.tip_pose(q)[:3], model.tip_pose(HOME)[:3], atol=1e-5)
        assert np.abs(q - HOME).max() > 0.05


def test_a_region_is_reached_somewhere(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """The tip ends inside the region, though its centre is blocked."""
    planner = MotionPlanner(model, PlannerConfig(elbows=2))
    planner.update(boxes.snapshot(boxes.box("rock", (0.1, 0.1, 0.1), DOWN[:3])))
    region = PoseRegion(center=tuple(DOWN), position=(0.2, 0.2, 0.1), rotation=(0.1, 0.1, 1.0))
    plan = planner.plan_to_pose(HOME, region, rng=rng)
    assert plan.report.goal > 0
    assert np.all(np.abs(model.tip_pose(plan.trajectory.q[-1])[:3] - DOWN[:3]) <= 0.2 + 1e-6)


def test_clearance_is_kept_where_it_can_be(model: RobotModel, boxes: Boxes) -> None:
    """Paths around a screen stay farther away when the settings ask for it, and the report says how far."""
    shares = []
    for clearance in (0.0, 0.03):
        planner = MotionPlanner(model, PlannerConfig(clearance=clearance, measure_clearance=True))
        planner.update(boxes.snapshot(boxes.screen()))
        side = np.array([0.8, 0.35, 0.0, -0.35, 0.0, 0.0, 0.0])
        plan = planner.plan_to_configuration(HOME - side, HOME + side * [1, -1, 1, -1, 1, 1, 1], rng=np.random.default_rng(0))
        assert plan.report.clearance is not None
        shares.append((plan.report.method, plan.report.clearance))
    assert all(clearance > 0.0 for _, clearance in shares)
    if shares[1][0] == "sampled":
        assert shares[1][1] > 0.02
