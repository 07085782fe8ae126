"""Whatever is asked of the planner, it answers with a plan or with one of the typed reasons, and the reason carries evidence."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from rlbench_pin.errors import GoalInCollision, NoIkSolution, NoPath, NotStraight, PlanningError
from rlbench_pin.planning.planner import MotionPlanner, PlannerConfig
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import pose_at
from tests.worlds_for_tests import HOME, TABLE_TOP, Boxes

REASONS = {"unreachable", "start in collision", "goal in collision", "no path", "no straight line", "timing"}


def random_pose(rng: np.random.Generator) -> np.ndarray:
    """A pose anywhere in and around the reach of the arm."""
    quaternion = rng.normal(size=4)
    return np.concatenate([rng.uniform([-0.5, -0.8, 0.6], [0.9, 0.8, 1.9]), quaternion / np.linalg.norm(quaternion)])


def outcomes(model: RobotModel, boxes: Boxes, count: int, seed: int) -> Counter[str]:
    """Ask for random poses, one after the other, from wherever the arm is; say how often what came out."""
    rng = np.random.default_rng(seed)
    planner = MotionPlanner(model, PlannerConfig(checks=3000))
    world = boxes.snapshot(boxes.screen(), *boxes.cubes(6))
    counts: Counter[str] = Counter()
    q = HOME
    for i in range(count):
        planner.update(world)
        try:
            plan = planner.plan_to_pose(
                q, random_pose(rng), rng=rng, ignore_collisions=i % 7 == 6, straight=[None, True, False][i % 3]
            )
        except PlanningError as error:
            counts[error.reason] += 1
            assert error.evidence
            continue
        counts["planned"] += 1
        q = plan.trajectory.q[-1] if i % 7 != 6 else q
    return counts


@pytest.mark.simulation
def test_random_poses_are_planned_or_refused_with_a_reason(model: RobotModel, boxes: Boxes) -> None:
    """Three hundred random poses."""
    counts = outcomes(model, boxes, 300, seed=0)
    assert set(counts) <= {*REASONS, "planned"}
    assert counts["planned"] > 20
    assert counts["unreachable"] > 20
    assert counts["goal in collision"] > 5


@pytest.mark.slow
def test_ten_thousand_random_poses(model: RobotModel, boxes: Boxes) -> None:
    """The same, long enough to meet rare reasons."""
    counts = outcomes(model, boxes, 10_000, seed=1)
    assert set(counts) <= {*REASONS, "planned"}


def test_out_of_reach_says_what_is_nearest(model: RobotModel, rng: np.random.Generator) -> None:
    """The nearest pose is one that the arm reaches, and the error is measured from it."""
    wanted = pose_at((1.2, 0.0, 1.0), np.pi, 0.0, np.pi)
    with pytest.raises(NoIkSolution) as caught:
        MotionPlanner(model).plan_to_pose(HOME, wanted, rng=rng)
    nearest = caught.value.nearest
    assert nearest is not None
    assert np.linalg.norm(nearest[:3] - wanted[:3]) == pytest.approx(caught.value.position_error, rel=0.3, abs=0.02)


def test_a_blocked_goal_says_how_deep(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """Pairs come with their penetration, the deepest first."""
    planner = MotionPlanner(model)
    planner.update(boxes.snapshot(boxes.box("rock", (0.2, 0.2, 0.3), (0.35, 0.25, TABLE_TOP + 0.15))))
    with pytest.raises(GoalInCollision, match="mm deep") as caught:
        planner.plan_to_pose(HOME, pose_at((0.35, 0.25, TABLE_TOP + 0.1), np.pi, 0.0, np.pi), rng=rng)
    assert caught.value.depths[0] == max(caught.value.depths) > 0.01


def test_a_broken_line_says_where_and_by_what(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """The fraction that was reached and the obstacle are named."""
    planner = MotionPlanner(model)
    planner.update(boxes.snapshot(boxes.screen()))
    q = planner.plan_to_pose(HOME, pose_at((0.35, -0.25, TABLE_TOP + 0.1), np.pi, 0.0, np.pi), rng=rng).trajectory.q[-1]
    with pytest.raises(NotStraight, match="screen") as caught:
        planner.plan_to_pose(q, pose_at((0.35, 0.25, TABLE_TOP + 0.1), np.pi, 0.0, np.pi), straight=True, rng=rng)
    assert 0.0 < caught.value.fraction < 1.0


def test_no_path_says_what_was_spent(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """The budget is in the evidence."""
    planner = MotionPlanner(model, PlannerConfig(checks=60))
    planner.update(boxes.snapshot(boxes.box("gate", (1.0, 0.02, 2.5), (0.45, 0.0, TABLE_TOP + 1.25), fixed=True)))
    side = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    with pytest.raises(NoPath) as caught:
        planner.plan_to_configuration(HOME - side, HOME + side, rng=rng)
    assert caught.value.evidence["checks"] == 60
