"""Differential inverse kinematics: reaches poses, follows twists, keeps limits, passes singularities."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from rlbench_pin.control import DifferentialIK, DifferentialIKConfig, DifferentialIKQP, PostureObjective, TipObjective
from rlbench_pin.control.qp.objectives import Manipulability
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, pose_to_se3
from tests.control.analytic_worlds import random_goals

DT = 0.05


@pytest.fixture(scope="module")
def controller(model: RobotModel) -> DifferentialIK:
    """A controller with default settings."""
    return DifferentialIK(model)


def pose_error(model: RobotModel, q: FloatArray, pose: FloatArray) -> tuple[float, float]:
    """Return distance [m] and angle [rad] of the tip from a pose."""
    error = pin.log6(model.tip_se3(q).actInv(pose_to_se3(pose))).vector
    return float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))


def test_poses_are_reached_within_limits(model: RobotModel, controller: DifferentialIK, rng: np.random.Generator) -> None:
    """From wherever it is, the arm comes to rest at reachable poses, and no limit is broken on the way."""
    q, v, limits, reached = model.home.copy(), np.zeros(7), model.limits, 0
    for goal in random_goals(model, rng, 20, 0.3):
        for _ in range(80):
            u = controller.velocity_to_pose(q, v, goal)
            assert np.all(np.abs(u) <= limits.velocity + 1e-9)
            assert np.all(np.abs(u - v) <= DT * limits.acceleration + 1e-9)
            q, v = q + DT * u, u
            assert limits.contains(q, 1e-9)
        distance, angle = pose_error(model, q, goal)
        reached += distance < 1e-4 and angle < 1e-3
    assert reached >= 18  # joint limits stop the straight way to some


def test_the_tip_goes_straight(model: RobotModel) -> None:
    """At a speed that joints can start with, the tip stays on the line to a pose beside it."""
    controller = DifferentialIK(model, DifferentialIKConfig(tip=TipObjective(linear_speed=0.1)))
    start = model.home + [0, 0.2, 0, -1.0, 0, 1.0, 0]
    q, v, origin = start.copy(), np.zeros(7), model.tip_pose(start)
    goal = origin + [0.1, 0.15, -0.05, 0, 0, 0, 0]
    line = (goal - origin)[:3] / np.linalg.norm((goal - origin)[:3])
    for _ in range(60):
        v = controller.velocity_to_pose(q, v, goal)
        q = q + DT * v
        offset = model.tip_pose(q)[:3] - origin[:3]
        assert np.linalg.norm(offset - (offset @ line) * line) < 1.5e-3
    assert pose_error(model, q, goal)[0] < 1e-4


@pytest.mark.parametrize("frame", ["world", "tip"])
def test_twists_are_followed(model: RobotModel, controller: DifferentialIK, frame: str) -> None:
    """A twist that the limits allow is what the tip does, along the axes it was given in."""
    q = model.home + [0, 0.2, 0, -1.0, 0, 1.0, 0]
    twist = np.array([0.05, -0.03, 0.02, 0.1, -0.05, 0.08])
    v = controller.velocity_for_twist(q, np.zeros(7), twist, frame)  # type: ignore[arg-type]
    np.testing.assert_allclose(model.jacobian(q, frame) @ v, twist, atol=5e-4)  # type: ignore[arg-type]


def test_the_null_space_moves_towards_the_posture(model: RobotModel) -> None:
    """Holding the tip still, the elbow turns until the arm is as near to its posture as the tip allows."""
    posture = model.home + [0.3, 0, -0.3, 0, 0, 0, 0]
    controller = DifferentialIK(model, posture=posture)
    q, v, goal = model.home + [0, 0.2, 0, -1.0, 0, 1.0, 0], np.zeros(7), model.tip_pose(model.home + [0, 0.2, 0, -1.0, 0, 1.0, 0])
    before = np.linalg.norm(q - posture)
    for _ in range(200):
        v = controller.velocity_to_pose(q, v, goal)
        q = q + DT * v
    assert np.linalg.norm(q - posture) < before - 0.05
    assert pose_error(model, q, goal)[0] < 1e-4


def test_no_target_out_of_reach_makes_the_arm_shake(model: RobotModel, controller: DifferentialIK) -> None:
    """Stretched towards a pose it cannot reach, the arm comes to rest instead of trembling at the singularity."""
    q, v = model.home.copy(), np.zeros(7)
    for k in range(200):
        v = controller.velocity_to_pose(q, v, np.array([1.5, 0.2, 1.3, 0.0, 0.7071, 0.0, 0.7071]))
        q = q + DT * v
        if k > 150:
            assert np.abs(v).max() < 0.05


def test_a_singular_start_is_left(model: RobotModel, controller: DifferentialIK) -> None:
    """From a configuration with a stretched wrist the arm moves on to its goal."""
    q, v = model.home.copy(), np.zeros(7)
    q[5] = 0.0
    goal = model.tip_pose(model.home + [0.2, 0.3, 0, -0.8, 0, 0.8, 0])
    for _ in range(120):
        v = controller.velocity_to_pose(q, v, goal)
        q = q + DT * v
    assert pose_error(model, q, goal)[0] < 1e-3


def test_both_formulations_are_one_problem(model: RobotModel, controller: DifferentialIK, rng: np.random.Generator) -> None:
    """PlaCo and the written-out QP by OSQP give the same velocities along whole motions."""
    written = DifferentialIKQP(model)
    q, v = model.home.copy(), np.zeros(7)
    for goal in random_goals(model, rng, 6):
        for _ in range(25):
            u = controller.velocity_to_pose(q, v, goal)
            np.testing.assert_allclose(written.velocity_to_pose(q, v, goal), u, atol=3e-3)
            q, v = q + DT * u, u


def test_a_command_depends_on_its_arguments_alone(model: RobotModel, rng: np.random.Generator) -> None:
    """A controller that has worked gives the same bytes as a new one."""
    worked, goals = DifferentialIK(model), random_goals(model, rng, 30)
    states = [(rng.uniform(model.limits.lower, model.limits.upper), 0.3 * rng.normal(size=7)) for _ in goals]
    for (q, v), goal in zip(states, goals, strict=True):
        used = worked.velocity_to_pose(q, v, goal)
        np.testing.assert_array_equal(used, DifferentialIK(model).velocity_to_pose(q, v, goal))


def test_limits_crossed_at_the_start_are_left_behind(model: RobotModel, controller: DifferentialIK) -> None:
    """Outside a position limit, and too fast, the command is within the acceleration limit and leads back."""
    q, v, limits = model.home.copy(), np.zeros(7), model.limits
    q[3], v[3] = limits.upper[3] + 0.1, limits.velocity[3] + 0.5
    for _ in range(40):
        u = controller.velocity_to_pose(q, v, model.tip_pose(model.home))
        assert np.all(np.abs(u - v) <= DT * limits.acceleration + 1e-9)
        q, v = q + DT * u, u
    assert limits.contains(q, 1e-9)
    assert np.all(np.abs(v) <= limits.velocity)


def test_bad_input_is_refused_and_leaves_no_trace(model: RobotModel) -> None:
    """NaN, a zero quaternion or a wrong shape raise, and the next command is as if nothing had happened."""
    controller, goal, v = DifferentialIK(model), model.tip_pose(model.home + 0.1), np.zeros(7)
    clean = controller.velocity_to_pose(model.home, v, goal)
    for bad in (np.full(7, np.nan), [0.3, 0, 1, 0, 0, 0, 0], np.zeros(6)):
        with pytest.raises(InvalidTarget):
            controller.velocity_to_pose(model.home, v, bad)
    with pytest.raises(InvalidTarget):
        controller.velocity_to_pose(np.full(7, np.nan), v, goal)
    with pytest.raises(InvalidTarget):
        controller.velocity_for_twist(model.home, v, np.zeros(7))
    np.testing.assert_array_equal(controller.velocity_to_pose(model.home, v, goal), clean)


def test_settings_are_checked() -> None:
    """A speed of zero is refused when it is set."""
    with pytest.raises(ValueError, match="linear_speed"):
        TipObjective(linear_speed=0.0)


def test_manipulability_is_the_product_of_the_singular_values(model: RobotModel, rng: np.random.Generator) -> None:
    """It equals sqrt(det(J J^T)) and vanishes with the rank."""
    manipulability = Manipulability(model.size)
    for _ in range(20):
        jacobian = model.jacobian(rng.uniform(model.limits.lower, model.limits.upper))
        assert manipulability(jacobian) == pytest.approx(np.prod(np.linalg.svd(jacobian)[1]), abs=1e-12)
    jacobian[5] = 2.0 * jacobian[4]
    assert manipulability(jacobian) == pytest.approx(0.0, abs=1e-12)


def test_damping_rises_near_singularities_for_steps_that_are_not_small() -> None:
    """Far from singularities, and for steps of nothing, only the base weight is left."""
    posture = PostureObjective()
    assert posture.damping(1.0, 0.1) == posture.damping(0.0, 0.0) == posture.weight
    assert posture.damping(0.0, 0.1) > posture.damping(0.0, 1e-3) > posture.weight
