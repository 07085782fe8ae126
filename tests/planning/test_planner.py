"""Whole motions: from where the arm is to where it should be."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rlbench_pin.errors import GoalInCollision, NoIkSolution, NoPath, NotStraight, StartInCollision
from rlbench_pin.planning.planner import MotionPlanner, Plan, PlannerConfig
from rlbench_pin.robot.description import robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import pose_at, rotation_distance
from tests.worlds_for_tests import HOME, TABLE_TOP, Boxes

LEFT, RIGHT = (
    pose_at((0.35, 0.25, TABLE_TOP + 0.1), np.pi, 0.0, np.pi),
    pose_at((0.35, -0.25, TABLE_TOP + 0.1), np.pi, 0.0, np.pi),
)


@pytest.fixture
def planner(model: RobotModel) -> MotionPlanner:
    """A planner with an empty world."""
    return MotionPlanner(model)


def assert_at(model: RobotModel, q: np.ndarray, pose: np.ndarray) -> None:
    """Check that the tip is at a pose."""
    reached = model.tip_pose(q)
    np.testing.assert_allclose(reached[:3], pose[:3], atol=1e-5)
    assert rotation_distance(reached, pose) < 1e-4


def touches(model: RobotModel, snapshot: WorldSnapshot, plan: Plan) -> list[tuple[str, str]]:
    """What a plan touches, checked by a planner of its own."""
    checker = MotionPlanner(model).collision
    checker.update(snapshot)
    return [pair for q in plan.trajectory.q[::2] for pair in checker.colliding_pairs(q)]


def around_the_screen(planner: MotionPlanner, snapshot: WorldSnapshot, seed: int = 0) -> Plan:
    """Go to the right of the screen, then plan to its left."""
    rng = np.random.default_rng(seed)
    planner.update(snapshot)
    right = planner.plan_to_pose(HOME, RIGHT, rng=rng).trajectory.q[-1]
    return planner.plan_to_pose(right, LEFT, rng=rng)


def test_a_free_way_is_straight(planner: MotionPlanner, boxes: Boxes, model: RobotModel, rng: np.random.Generator) -> None:
    """Without obstacles the tip goes on a line, and arrives."""
    planner.update(boxes.snapshot())
    plan = planner.plan_to_pose(HOME, LEFT, rng=rng)
    assert plan.report.method == "straight"
    np.testing.assert_array_equal(plan.trajectory.q[0], HOME)
    assert_at(model, plan.trajectory.q[-1], LEFT)


@pytest.mark.simulation
def test_a_screen_is_gone_around(planner: MotionPlanner, boxes: Boxes, model: RobotModel) -> None:
    """The sampled motion arrives and touches nothing, at rest at both ends."""
    snapshot = boxes.snapshot(boxes.screen(), *boxes.cubes(3))
    methods = set()
    for seed in range(5):
        plan = around_the_screen(planner, snapshot, seed)
        methods.add(plan.report.method)
        assert touches(model, snapshot, plan) == []
        assert_at(model, plan.trajectory.q[-1], LEFT)
        assert np.abs(plan.trajectory.v).max() <= 1.0
        assert np.abs(plan.trajectory.a).max() <= 4.0
    assert "sampled" in methods
    assert "straight" not in methods


def test_only_straight_means_only_straight(planner: MotionPlanner, boxes: Boxes, rng: np.random.Generator) -> None:
    """With `straight=True` an obstacle on the line is an error; with False the line is not even tried."""
    snapshot = boxes.snapshot(boxes.screen())
    planner.update(snapshot)
    right = planner.plan_to_pose(HOME, RIGHT, rng=rng).trajectory.q[-1]
    with pytest.raises(NotStraight):
        planner.plan_to_pose(right, LEFT, straight=True, rng=rng)
    assert planner.plan_to_pose(HOME, RIGHT, straight=False, rng=rng).report.method != "straight"


def test_collisions_can_be_ignored(planner: MotionPlanner, boxes: Boxes, rng: np.random.Generator) -> None:
    """Without collision checks the screen does not matter."""
    planner.update(boxes.snapshot(boxes.screen()))
    right = planner.plan_to_pose(HOME, RIGHT, rng=rng).trajectory.q[-1]
    plan = planner.plan_to_pose(right, LEFT, ignore_collisions=True, rng=rng)
    assert not plan.report.certified
    assert plan.report.method == "straight"


@pytest.mark.simulation
def test_a_motion_that_ignores_collisions_never_folds_the_arm_into_itself(model: RobotModel, planner: MotionPlanner) -> None:
    """Where the joints' line would, another way is found; what the world has there does not matter."""
    checker, rng, found = MotionPlanner(model).collision, np.random.default_rng(3), 0
    planner.update(WorldSnapshot((), HOME, np.full(2, 0.04)))
    while found < 4:
        q, goal = rng.uniform(model.limits.lower, model.limits.upper, (2, model.size))
        line = [q + s * (goal - q) for s in np.linspace(0.0, 1.0, 30)]
        if checker.colliding_pairs(q) or checker.colliding_pairs(goal) or not any(checker.colliding_pairs(p) for p in line):
            continue
        found += 1
        plan = planner.plan_to_configuration(q, goal, ignore_collisions=True, rng=rng)
        assert not plan.report.certified
        assert not any(checker.colliding_pairs(p) for p in plan.trajectory.q)
    assert planner.collision.distances(HOME)[0].distance > 0.0


def test_a_goal_inside_the_arm_itself_is_refused_although_collisions_are_ignored(
    model: RobotModel, planner: MotionPlanner
) -> None:
    """The error names the links."""
    checker, rng = MotionPlanner(model).collision, np.random.default_rng(0)
    folded = next(
        q for q in rng.uniform(model.limits.lower, model.limits.upper, (500, model.size)) if checker.goal_in_collision(q)
    )
    with pytest.raises(GoalInCollision) as refusal:
        planner.plan_to_configuration(HOME, folded, ignore_collisions=True, rng=rng)
    assert all("panda_" in link for pair in refusal.value.pairs for link in pair)


def test_an_allowed_body_is_no_obstacle(planner: MotionPlanner, boxes: Boxes, rng: np.random.Generator) -> None:
    """Naming the screen lets the arm pass through it."""
    planner.update(boxes.snapshot(boxes.screen()))
    right = planner.plan_to_pose(HOME, RIGHT, rng=rng).trajectory.q[-1]
    assert planner.plan_to_pose(right, LEFT, allowed=("screen",), straight=True, rng=rng).report.method == "straight"


def test_the_best_of_several_goals_is_taken(planner: MotionPlanner, boxes: Boxes, rng: np.random.Generator) -> None:
    """Of equally good poses one that is free is reached, and the report says which."""
    planner.update(boxes.snapshot(boxes.box("rock", (0.2, 0.2, 0.3), (0.35, 0.25, TABLE_TOP + 0.15))))
    plan = planner.plan_to_pose(HOME, [LEFT, RIGHT], rng=rng)
    assert plan.report.goal == 1


def test_errors_say_what_is_wrong(planner: MotionPlanner, boxes: Boxes, rng: np.random.Generator) -> None:
    """Out of reach, blocked goal and blocked start are different errors."""
    planner.update(boxes.snapshot(boxes.box("rock", (0.2, 0.2, 0.3), (0.35, 0.25, TABLE_TOP + 0.15))))
    with pytest.raises(NoIkSolution):
        planner.plan_to_pose(HOME, pose_at((1.5, 0.0, 1.0), np.pi, 0.0, np.pi), rng=rng)
    with pytest.raises(GoalInCollision, match="rock"):
        planner.plan_to_pose(HOME, LEFT, rng=rng)
    with pytest.raises(StartInCollision, match="table"):
        planner.plan_to_pose(HOME + np.array([0.0, 0.9, 0.0, -0.9, 0.0, 0.0, 0.0]), RIGHT, rng=rng)


def test_a_goal_that_is_shut_in_has_no_path(model: RobotModel, boxes: Boxes, rng: np.random.Generator) -> None:
    """The budget ends the search."""
    planner = MotionPlanner(model, PlannerConfig(checks=60))
    side = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    planner.update(boxes.snapshot(boxes.box("gate", (1.0, 0.02, 2.5), (0.45, 0.0, TABLE_TOP + 1.25), fixed=True)))
    with pytest.raises(NoPath) as caught:
        planner.plan_to_configuration(HOME - side, HOME + side, rng=rng)
    assert caught.value.checks <= 60


def test_a_narrow_grasp_is_reached(planner: MotionPlanner, boxes: Boxes, model: RobotModel, rng: np.random.Generator) -> None:
    """Fingers may go nearer to a cube they are about to grasp than the clearance on the way."""
    width = 0.076
    snapshot = boxes.snapshot(boxes.box("cube", (width, width, width), (0.3, 0.0, TABLE_TOP + width / 2)))
    planner.update(snapshot)
    above = planner.plan_to_pose(HOME, pose_at((0.3, 0.0, TABLE_TOP + 0.2), np.pi, 0.0, np.pi), rng=rng).trajectory.q[-1]
    plan = planner.plan_to_pose(above, pose_at((0.3, 0.0, TABLE_TOP + 0.05), np.pi, 0.0, np.pi), rng=rng)
    assert plan.report.method == "straight"
    assert touches(model, snapshot, plan) == []


def test_a_held_cube_is_lifted_carried_and_set_down(
    planner: MotionPlanner, boxes: Boxes, model: RobotModel, rng: np.random.Generator
) -> None:
    """Pick and place: the cube leaves the table, goes around the screen, and is set down on the table again."""
    cube = boxes.box("cube", (0.05, 0.05, 0.05), (0.35, -0.25, TABLE_TOP + 0.025))
    at_cube = pose_at((0.35, -0.25, TABLE_TOP + 0.025), np.pi, 0.0, np.pi)
    planner.update(boxes.snapshot(cube, boxes.screen()))
    q = planner.plan_to_pose(HOME, at_cube, rng=rng).trajectory.q[-1]
    planner.update(boxes.snapshot(cube, boxes.screen(), arm=q, opening=0.025, attached=("cube",)))
    plan = planner.plan_to_pose(q, pose_at((0.35, 0.25, TABLE_TOP + 0.025), np.pi, 0.0, np.pi), rng=rng)
    assert plan.report.method == "sampled"
    checker = MotionPlanner(model).collision
    checker.update(boxes.snapshot(cube, boxes.screen(), arm=q, opening=0.025, attached=("cube",)))
    deepest = min(d.distance for q in plan.trajectory.q[::5] for d in checker.distances(q, 0.01) or checker.distances(q)[:1])
    assert deepest > -0.0025


def test_a_curve_is_followed(planner: MotionPlanner, boxes: Boxes, model: RobotModel, rng: np.random.Generator) -> None:
    """The tip passes all poses of a curve without stopping."""
    planner.update(boxes.snapshot())
    start = planner.plan_to_pose(HOME, LEFT, rng=rng).trajectory.q[-1]
    angles = np.linspace(0.2, 2.0, 10)
    poses = [pose_at((0.35 - 0.1 + 0.1 * np.cos(a), 0.25 + 0.1 * np.sin(a), TABLE_TOP + 0.1), np.pi, 0.0, np.pi) for a in angles]
    plan = planner.plan_curve(start, poses, rng=rng)
    tips = np.array([model.tip_pose(q)[:3] for q in plan.trajectory.q])
    for pose in poses:
        assert np.linalg.norm(tips - pose[:3], axis=1).min() < 5e-3
    inner = slice(len(plan.trajectory.times) // 5, -len(plan.trajectory.times) // 5)
    assert np.linalg.norm(plan.trajectory.v, axis=1)[inner].min() > 0.05


def test_reachable_returns_a_configuration(
    planner: MotionPlanner, boxes: Boxes, model: RobotModel, rng: np.random.Generator
) -> None:
    """Reach is asked with or without collisions."""
    planner.update(boxes.snapshot(boxes.box("rock", (0.2, 0.2, 0.3), (0.35, 0.25, TABLE_TOP + 0.15))))
    assert_at(model, planner.reachable(HOME, LEFT, rng), LEFT)
    with pytest.raises(GoalInCollision):
        planner.reachable(HOME, LEFT, rng, ignore_collisions=False)
    with pytest.raises(NoIkSolution):
        planner.reachable(HOME, pose_at((2.0, 0.0, 1.0)), rng)


def test_measured_joints_beyond_a_limit_are_accepted(
    planner: MotionPlanner, boxes: Boxes, model: RobotModel, rng: np.random.Generator
) -> None:
    """A start that overshoots a limit by a measuring error is moved back to the limit."""
    planner.update(boxes.snapshot())
    q = HOME.copy()
    q[0] = model.limits.upper[0] + 1e-4
    plan = planner.plan_to_pose(q, LEFT, rng=rng)
    assert model.limits.contains(plan.trajectory.q[0])


def test_settings_that_cannot_work_are_refused() -> None:
    """Wrong settings fail when they are made."""
    with pytest.raises(ValueError, match="rrt_connect"):
        PlannerConfig(algorithm="magic")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="max_velocity"):
        PlannerConfig(max_velocity=0.0)


def digest(folder: Path) -> str:
    """Fingerprint of three plans in a fixed world."""
    boxes = Boxes(folder)
    planner = MotionPlanner(RobotModel(robot_description("panda")))
    snapshot = boxes.snapshot(boxes.screen(), *boxes.cubes(3))
    plans = [around_the_screen(planner, snapshot, seed) for seed in (1, 2, 3)]
    return hashlib.sha256(b"".join(p.trajectory.q.tobytes() + p.trajectory.times.tobytes() for p in plans)).hexdigest()


@pytest.mark.simulation
def test_same_arguments_same_bytes(tmp_path: Path, planner: MotionPlanner, boxes: Boxes) -> None:
    """Another process, and other plans in between, do not change a plan; and nothing is printed."""
    first = digest(tmp_path)
    around_the_screen(planner, boxes.snapshot(boxes.screen()), seed=99)
    assert digest(tmp_path) == first
    code = (
        "import sys; sys.path.insert(0, '.'); from pathlib import Path; from tests.planning.test_planner import digest;"
        f"sys.stdout.write(digest(Path({str(tmp_path)!r})))"
    )
    run = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == first
    assert run.stderr == ""
