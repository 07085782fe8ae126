"""Lists and tuples are taken where arrays are, and give the same numbers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from rlbench_pin import control, planning, robot, spatial
from rlbench_pin.robot import RobotModel, Trajectory, robot_description

POSE = np.array([0.3, 0.2, 1.0, 0.0, 1.0, 0.0, 0.0])
MODEL = RobotModel(robot_description("panda"))
Q, V, A = MODEL.home + 0.05, np.full(7, 0.1), np.full(7, 0.2)
TIMES, ENDS, RESTS = np.array([0.0, 1.0]), np.array([Q, Q + 0.1]), np.zeros((2, 7))
LOAD = np.diag([0.1, 0.1, 0.1])


def _trajectory(as_: Callable) -> Trajectory:
    return Trajectory(as_(TIMES), as_(ENDS), as_(RESTS), as_(RESTS))


CALLS: dict[str, Callable] = {
    **{
        f"RobotModel.{name}": lambda as_, name=name: getattr(MODEL, name)(as_(Q))
        for name in ("full_configuration", "tip_pose", "joint_poses", "jacobian", "manipulability", "mass_matrix", "gravity")
    },
    "RobotModel.full_configuration, fingers": lambda as_: MODEL.full_configuration(as_(Q), as_(np.array([0.01, 0.02]))),
    "RobotModel.jacobian_dot": lambda as_: MODEL.jacobian_dot(as_(Q), as_(V)),
    "RobotModel.coriolis": lambda as_: MODEL.coriolis(as_(Q), as_(V)),
    "RobotModel.inverse_dynamics": lambda as_: MODEL.inverse_dynamics(as_(Q), as_(V), as_(A)),
    "RobotModel.forward_dynamics": lambda as_: MODEL.forward_dynamics(as_(Q), as_(V), as_(A)),
    "inverse_dynamics_derivatives": lambda as_: vars(robot.inverse_dynamics_derivatives(MODEL, as_(Q), as_(V), as_(A))),
    "forward_dynamics_derivatives": lambda as_: vars(robot.forward_dynamics_derivatives(MODEL, as_(Q), as_(V), as_(A))),
    "jacobian_derivative": lambda as_: robot.jacobian_derivative(MODEL, as_(Q)),
    "manipulability_gradient": lambda as_: robot.manipulability_gradient(MODEL, as_(Q)),
    "JointLimits.contains": lambda as_: MODEL.limits.contains(as_(Q)),
    "CollisionModel.penetrations": lambda as_: robot.CollisionModel(MODEL).penetrations(as_(Q)),
    "DistanceModel.nearest": lambda as_: [d.distance for d in robot.DistanceModel(MODEL).nearest(as_(Q), 3)],
    "Trajectory.sample": lambda as_: _trajectory(as_).sample(0.3),
    "MotionPlanner.plan_to_pose": lambda as_: (
        planning.MotionPlanner(MODEL).plan_to_pose(as_(Q), as_(POSE), rng=np.random.default_rng(0)).path
    ),
    "symmetric_poses": lambda as_: planning.symmetric_poses(as_(POSE), 4),
    "solve_ik": lambda as_: planning.solve_ik(MODEL, as_(POSE), as_(Q), np.random.default_rng(0)),
    "straight_path": lambda as_: planning.straight_path(MODEL, as_(Q), as_(MODEL.tip_pose(Q) + 0.01 * np.eye(7)[2])),
    "self_motions": lambda as_: planning.self_motions(MODEL, as_(Q)),
    "DifferentialIK": lambda as_: control.DifferentialIK(MODEL, posture=as_(Q)).velocity_to_pose(as_(Q), as_(V), as_(POSE)),
    "SafetyFilter": lambda as_: control.SafetyFilter(MODEL).filter(as_(Q), as_(V), as_(A)).velocity,
    "JointBounds.interval": lambda as_: control.JointBounds(MODEL.limits, 0.05).interval(as_(Q), as_(V)),
    "PoseIK": lambda as_: control.PoseIK(MODEL).solve(as_(POSE), as_(Q), np.random.default_rng(0)).q,
    "VelocityFollowing": lambda as_: control.VelocityFollowing(MODEL.limits).command(_trajectory(as_), 0.1, as_(Q), as_(V)),
    "ComputedTorque": lambda as_: control.ComputedTorque(MODEL).command(_trajectory(as_), 0.1, as_(Q), as_(V)),
    "CartesianImpedance": lambda as_: control.CartesianImpedance(MODEL, as_(A[:6])).torque(as_(Q), as_(V), as_(POSE)),
    "pose_to_matrix": lambda as_: spatial.pose_to_matrix(as_(POSE)),
    "matrix_to_pose": lambda as_: spatial.matrix_to_pose(as_(np.eye(4))),
    "compose": lambda as_: spatial.compose(as_(POSE), as_(POSE)),
    "rotation_distance": lambda as_: spatial.rotation_distance(as_(POSE), as_(POSE)),
}


def _tuple(array: np.ndarray) -> tuple:
    return tuple(map(_tuple, array)) if array.ndim > 1 else tuple(array.tolist())


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("as_", [np.ndarray.tolist, _tuple], ids=["list", "tuple"])
def test_a_list_is_as_good_as_an_array(name: str, as_: Callable) -> None:
    """Bit for bit."""
    np.testing.assert_equal(CALLS[name](as_), CALLS[name](lambda array: array))


def test_a_payload_may_be_lists() -> None:
    """Centre and inertia of what the gripper carries."""
    with_lists, with_arrays = RobotModel(robot_description("panda")), RobotModel(robot_description("panda"))
    with_lists.set_payload(0.5, [0.0, 0.0, 0.1], LOAD.tolist())
    with_arrays.set_payload(0.5, np.array([0.0, 0.0, 0.1]), LOAD)
    np.testing.assert_array_equal(with_lists.gravity(Q), with_arrays.gravity(Q))
