"""Inverse kinematics with some joints pinned to given angles; the package says how it differs from `ik`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import InvalidRequest, NoIkSolution
from rlbench_pin.planning.requests import as_goal_pose
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3
from rlbench_pin.values import as_record, as_vector, as_whole

POSITION_TOLERANCE, ROTATION_TOLERANCE = 1e-4, 1e-3
_ITERATIONS = 100


def solve_pinned_ik(model: RobotModel, pose: PoseLike, q_start: FloatArray, pinned: Mapping[int, float]) -> FloatArray:
    """Find the configuration near `q_start` that reaches `pose` with some joints at given angles.

    Each step is the damped least-squares step of the free joints: dq = J^T (J J^T + w I)^-1 e.

    Args:
        model: The arm.
        pose: Tip pose (7,) in the world.
        q_start: Where the descent begins (n,), [rad].
        pinned: Joint index -> angle [rad].

    Raises:
        InvalidRequest: NaN, a wrong shape, no numbers, or a joint that there is not.
        NoIkSolution: The free joints cannot bring the tip there.
    """
    as_record(model, RobotModel, "model", InvalidRequest)
    as_record(pinned, Mapping, "pinned", InvalidRequest)  # type: ignore[type-abstract]
    target, limits = pose_to_se3(as_goal_pose(pose)), model.limits
    joints = [as_whole(joint, "pinned joint", InvalidRequest, least=0, most=model.size - 1) for joint in pinned]
    as_vector(list(pinned.values()), len(joints), "The angles of pinned joints", InvalidRequest)
    q = as_vector(q_start, model.size, "q_start", InvalidRequest).copy()
    q[joints] = list(pinned.values())
    error = np.zeros(6)
    for _ in range(_ITERATIONS):
        error = pin.log6(model.tip_se3(q).actInv(target)).vector
        if np.linalg.norm(error[:3]) < POSITION_TOLERANCE and np.linalg.norm(error[3:]) < ROTATION_TOLERANCE:
            return q
        jacobian = model.jacobian(q, "tip").copy()
        jacobian[:, joints] = 0.0
        square = jacobian @ jacobian.T + (1e-6 + 0.05 * float(error @ error)) * np.eye(6)
        q = np.clip(q + jacobian.T @ np.linalg.solve(square, error), limits.lower, limits.upper)
        q[joints] = list(pinned.values())
    raise NoIkSolution(np.asarray(pose), float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:])), 1)
