"""What no planner can answer is refused at its door, by a typed error that names it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin.errors import InvalidRequest, InvalidValue, NoIkSolution, NotStraight, OutsideJointLimits, RetimingError
from rlbench_pin.planning import (
    MotionPlanner,
    PlannerConfig,
    PoseRegion,
    curve_path,
    retime,
    self_motions,
    solve_ik,
    solve_pinned_ik,
    straight_path,
    symmetric_poses,
)
from rlbench_pin.planning.kinematics import JOINT_LIMIT_TOLERANCE
from rlbench_pin.planning.timing import ArcLimits
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.spatial import FloatArray

Call = Callable[[MotionPlanner, object], object]


@pytest.fixture(scope="module")
def planner(model: RobotModel) -> MotionPlanner:
    """A planner in an empty world."""
    return MotionPlanner(model)


def goal(model: RobotModel) -> FloatArray:
    """Return a pose 10 cm below the tip at home."""
    pose = model.tip_pose(model.home)
    pose[2] -= 0.1
    return pose


def _rng() -> np.random.Generator:
    return np.random.default_rng(0)


STARTS: dict[str, Call] = {
    "pose": lambda p, q: p.plan_to_pose(q, goal(p.model), rng=_rng()),
    "configuration": lambda p, q: p.plan_to_configuration(q, p.model.home, rng=_rng()),
    "goal": lambda p, q: p.plan_to_configuration(p.model.home, q, rng=_rng()),
    "curve": lambda p, q: p.plan_curve(q, [goal(p.model)]),
    "reachable": lambda p, q: p.reachable(q, goal(p.model), _rng()),
    "line": lambda p, q: straight_path(p.model, q, goal(p.model)),
    "curve path": lambda p, q: curve_path(p.model, q, [goal(p.model)]),
    "elbows": lambda p, q: self_motions(p.model, q),
}
SEEDS: dict[str, Call] = {
    "ik": lambda p, q: solve_ik(p.model, goal(p.model), q, _rng()),
    "pinned ik": lambda p, q: solve_pinned_ik(p.model, goal(p.model), q, {0: 0.1}),
}
GOALS: dict[str, Call] = {
    "pose": lambda p, g: p.plan_to_pose(p.model.home, g, rng=_rng()),
    "straight": lambda p, g: p.plan_to_pose(p.model.home, g, rng=_rng(), straight=True),
    "curve": lambda p, g: p.plan_curve(p.model.home, g),
    "reachable": lambda p, g: p.reachable(p.model.home, g, _rng()),
    "ik": lambda p, g: solve_ik(p.model, g, p.model.home, _rng()),
    "pinned ik": lambda p, g: solve_pinned_ik(p.model, g, p.model.home, {0: 0.1}),
    "line": lambda p, g: straight_path(p.model, p.model.home, g),
    "curve path": lambda p, g: curve_path(p.model, p.model.home, g),
    "symmetry": lambda p, g: symmetric_poses(g, 4),
    "region": lambda p, g: PoseRegion(center=g),
}


@pytest.mark.parametrize("call", STARTS)
@pytest.mark.parametrize("shift", [10.0, -10.0, 1e9, 3e-3])
def test_ends_outside_the_joint_limits_are_refused(planner: MotionPlanner, call: str, shift: float) -> None:
    """The error names joint, value and limit; nothing is clipped silently."""
    q, limits = planner.model.home.copy(), planner.model.limits
    q[3] = (limits.upper if shift > 0.0 else limits.lower)[3] + shift
    with pytest.raises(OutsideJointLimits, match="panda_joint4") as caught:
        STARTS[call](planner, q)
    assert caught.value.joint == "panda_joint4"
    assert caught.value.value == q[3]
    assert caught.value.limit in (limits.lower[3], limits.upper[3])
    assert isinstance(caught.value, ValueError)


def test_measured_joints_may_overshoot_a_little(planner: MotionPlanner) -> None:
    """Up to 1e-3 rad beyond a limit motions begin and end at the limit, and say so by their first configuration."""
    limits = planner.model.limits
    q, end = planner.model.home.copy(), planner.model.home.copy()
    q[5], end[5] = limits.lower[5] - 0.9 * JOINT_LIMIT_TOLERANCE, limits.lower[5] + 0.1
    plan = planner.plan_to_configuration(q, end, ignore_collisions=True, rng=_rng())
    assert plan.path[0][5] == limits.lower[5]
    assert limits.contains(plan.path[0])


@pytest.mark.parametrize("call", {**STARTS, **SEEDS})
def test_what_is_no_configuration_is_refused(planner: MotionPlanner, call: str) -> None:
    """NaN, infinity, wrong shapes, text, complex and masked numbers, ragged lists, nothing at all."""
    home = planner.model.home
    masked = np.ma.masked_array(home, [True] + 6 * [False])
    wrong = [home * np.nan, home + np.inf, home[:3], home[None], "abc", None, home.astype(complex), list(map(str, home))]
    for q in [*wrong, masked, [[1.0], [1.0, 2.0]], [10**400] * 7, object(), home.astype(object), np.datetime64("now")]:
        with pytest.raises(InvalidRequest, match="Got"):
            ({**STARTS, **SEEDS})[call](planner, q)


@pytest.mark.parametrize("call", GOALS)
def test_what_is_no_pose_is_refused(planner: MotionPlanner, call: str) -> None:
    """Also a quaternion of norm zero, and no pose at all."""
    pose = goal(planner.model)
    wrong = [pose * np.nan, pose + np.inf, np.zeros(7), pose[:6], "x", None, [], [pose[:3]], pose.astype(complex), object(), 3]
    for bad in wrong:
        with pytest.raises(InvalidRequest):
            GOALS[call](planner, bad)


def test_far_goals_are_out_of_reach_at_once(planner: MotionPlanner) -> None:
    """A goal a million kilometres away costs no memory."""
    pose = goal(planner.model)
    pose[0] = 1e9
    with pytest.raises(NoIkSolution):
        planner.plan_to_pose(planner.model.home, pose, rng=_rng())
    for call in ("straight", "line", "curve path"):
        with pytest.raises(NotStraight, match="m long"):
            GOALS[call](planner, [pose] if call == "curve path" else pose)


def test_lists_are_taken_where_arrays_are(planner: MotionPlanner) -> None:
    """The same plan comes out."""
    home, pose = planner.model.home, goal(planner.model)
    a = planner.plan_to_pose(home, pose, rng=_rng())
    b = planner.plan_to_pose(home.tolist(), pose.tolist(), rng=_rng())  # type: ignore[arg-type]
    np.testing.assert_array_equal(a.trajectory.q, b.trajectory.q)


def test_other_arguments(planner: MotionPlanner) -> None:
    """Generators, names, settings, snapshots and counts are what they are called."""
    home, pose, model = planner.model.home, goal(planner.model), planner.model
    for rng in (0, None, np.random):
        with pytest.raises(InvalidRequest, match="default_rng"):
            planner.plan_to_pose(home, pose, rng=rng)  # type: ignore[arg-type]
    for allowed in ("cup", 5, [1]):
        with pytest.raises(InvalidRequest, match="list of names"):
            planner.plan_to_pose(home, pose, rng=_rng(), allowed=allowed)  # type: ignore[arg-type]
    with pytest.raises(InvalidRequest, match="PlannerConfig"):
        MotionPlanner(model, {})  # type: ignore[arg-type]
    with pytest.raises(InvalidRequest, match="WorldSnapshot"):
        planner.update(None)  # type: ignore[arg-type]
    for starts in (0, 1.5, "4", True):
        with pytest.raises(InvalidRequest, match="starts"):
            solve_ik(model, pose, home, _rng(), starts=starts)  # type: ignore[arg-type]
    for pinned in ({9: 0.1}, {0: float("nan")}, {"0": 0.1}, {0: "0.1"}):
        with pytest.raises(InvalidRequest):
            solve_pinned_ik(model, pose, home, pinned)  # type: ignore[arg-type]


def test_paths_that_cannot_be_timed(model: RobotModel) -> None:
    """NaN, wrong shapes, endless paths, limits that are none, and motions of more than an hour."""
    home, limits = model.home, model.limits
    for path in ([home, home * np.nan], home, [home[:3]] * 4, "abc", None, [], [home, home + 1e7], [home.astype(complex)] * 2):
        with pytest.raises(InvalidRequest, match="path"):
            retime(path, limits)  # type: ignore[arg-type]
    with pytest.raises(InvalidRequest, match="JointLimits"):
        retime([home, home + 0.1], None)  # type: ignore[arg-type]
    for jerk_time in (-1.0, float("nan"), "1", 1e9):
        with pytest.raises(InvalidRequest, match="jerk_time"):
            retime([home, home + 0.1], limits, jerk_time=jerk_time)  # type: ignore[arg-type]
    for slow in (1e-5, 1e-6):
        with pytest.raises(RetimingError, match="raise the limits"):
            retime([home, home + 0.1], limits.capped(slow, slow))  # type: ignore[arg-type]
        with pytest.raises(RetimingError):
            MotionPlanner(model, PlannerConfig(max_velocity=slow)).plan_to_configuration(home, home + 0.1, rng=_rng())


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), "1", None, True])
def test_speeds_are_above_zero(model: RobotModel, value: float) -> None:
    """Wherever a speed is given."""
    for make in (
        lambda: model.limits.capped(value, 1.0),
        lambda: ArcLimits(1.0, value),
        lambda: PlannerConfig(max_velocity=value),
        lambda: PlannerConfig(max_acceleration=value),
    ):
        with pytest.raises(InvalidValue):
            make()


def test_joint_limits_are_in_order(model: RobotModel) -> None:
    """NaN, and a lower limit above the upper one, are refused."""
    home = model.home
    with pytest.raises(InvalidValue, match="upper"):
        JointLimits(home, home - 1.0, home, home, home)
    with pytest.raises(InvalidValue, match="without NaN"):
        JointLimits(home, home + 1.0, home * np.nan, home, home)
