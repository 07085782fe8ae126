"""Inverse kinematics, and sets of equally good goals."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import GoalInCollision, NoIkSolution
from rlbench_pin.planning.kinematics import SAME, PoseRegion, cost, self_motions, solve_ik, symmetric_poses
from rlbench_pin.planning.planner import MotionPlanner, PlannerConfig
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import pose_at, rotation_distance
from tests.worlds_for_tests import HOME, TABLE_TOP, Boxes


@pytest.mark.simulation
def test_reachable_poses_are_reached(model: RobotModel, rng: np.random.Generator) -> None:
    """Of 1000 poses that the arm can take, at least 99.5 % are found, exactly and within the limits."""
    missed = 0
    for q in rng.uniform(model.limits.lower, model.limits.upper, (1000, model.size)):
        pose = model.tip_pose(q)
        try:
            (found,) = solve_ik(model, pose, model.home, rng)
        except NoIkSolution:
            missed += 1
            continue
        np.testing.assert_allclose(model.tip_pose(found), pose, atol=1e-5)
        assert model.limits.contains(found)
    assert missed <= 5


def test_the_seed_is_returned_when_it_is_there_already(model: RobotModel, rng: np.random.Generator) -> None:
    """Nothing moves without need."""
    (found,) = solve_ik(model, model.tip_pose(model.home), model.home, rng)
    np.testing.assert_array_equal(found, model.home)


def test_several_solutions_are_different_and_sorted(model: RobotModel, rng: np.random.Generator) -> None:
    """Branches come nearest first."""
    solutions = solve_ik(model, pose_at((0.3, 0.1, 0.95), np.pi, 0.0, np.pi), model.home, rng, max_solutions=5)
    assert len(solutions) == 5
    costs = [cost(model, model.home, q) for q in solutions]
    assert costs == sorted(costs)
    assert all(np.abs(a - b).max() >= SAME for i, a in enumerate(solutions) for b in solutions[:i])


def test_solutions_near_a_joint_limit_come_last(model: RobotModel) -> None:
    """A configuration at its limit is worth a detour."""
    middle = model.home.copy()
    edge = middle.copy()
    edge[0] = model.limits.upper[0] - 0.01
    near = edge.copy()
    near[0] = model.limits.upper[0] - 0.06
    assert cost(model, middle, edge) > cost(model, middle, near) + 1.0


def test_out_of_reach_says_how_far(model: RobotModel, rng: np.random.Generator) -> None:
    """The error carries the pose and the distance that remains."""
    pose = pose_at((1.5, 0.0, 1.0), np.pi, 0.0, np.pi)
    with pytest.raises(NoIkSolution) as caught:
        solve_ik(model, pose, model.home, rng, starts=10)
    np.testing.assert_array_equal(caught.value.pose, pose)
    assert caught.value.position_error > 0.3
    assert caught.value.starts == 10


def test_colliding_solutions_are_dropped(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """A pose inside an obstacle is reached by no free configuration; the error names what is in the way."""
    collision = CollisionModel(model)
    collision.update(boxes.snapshot(boxes.box("rock", (0.2, 0.2, 0.3), (0.3, 0.0, TABLE_TOP + 0.15))))
    with pytest.raises(GoalInCollision, match="rock"):
        solve_ik(model, pose_at((0.3, 0.0, TABLE_TOP + 0.2), np.pi, 0.0, np.pi), model.home, rng, collision=collision)
    (found,) = solve_ik(model, pose_at((0.3, 0.3, TABLE_TOP + 0.2), np.pi, 0.0, np.pi), model.home, rng, collision=collision)
    assert not collision.in_collision(found)


def test_same_generator_same_solutions(model: RobotModel) -> None:
    """The result depends on nothing but the arguments."""
    pose = pose_at((0.1, 0.4, 1.0), 2.0, 0.5)
    first = solve_ik(model, pose, model.home, np.random.default_rng(5), max_solutions=4)
    second = solve_ik(model, pose, model.home, np.random.default_rng(5), max_solutions=4)
    np.testing.assert_array_equal(first, second)


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
