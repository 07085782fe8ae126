"""Poses: conventions and conversions.

A pose is a float64 array of shape (7,): `[x, y, z, qx, qy, qz, qw]`, metres and a unit Hamilton quaternion, w last.
`T_a_b` maps coordinates of frame b to frame a, so inner names cancel: `T_world_tip = T_world_base * T_base_tip`.
Internal functions may pass poses as `pin.SE3`; public functions use arrays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.errors import InvalidValue
from rlbench_pin.values import as_array, as_finite, as_number, as_pose, as_vector

FloatArray = NDArray[np.float64]
PoseLike = Sequence[float] | FloatArray

TABLE_HEIGHT = 0.752
"""Height of the table top above the floor, the origin of the world [m]."""


def above_table(height: float) -> float:
    """Return the world z [m] of a point `height` [m] above the table top, without rounding noise."""
    return round(TABLE_HEIGHT + as_number(height, "height"), 12)


IDENTITY: FloatArray = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
IDENTITY.setflags(write=False)


def pose_to_se3(pose: PoseLike) -> pin.SE3:
    """Convert a pose (7,) to `pin.SE3`; the quaternion is normalised.

    Raises:
        InvalidValue: It has another shape, or its quaternion is zero or not finite (also a ValueError).
    """
    p = as_vector(pose, 7, "A pose [x, y, z, qx, qy, qz, qw]")
    turn = p[3:]
    norm = math.sqrt(turn @ turn)
    if not 0.0 < norm < np.inf:
        raise InvalidValue(
            "A pose", pose, f"has a quaternion of norm {norm}", "The identity is [0, 0, 0, 1]; the order is x, y, z, w."
        )
    unit = p.copy()
    unit[3:] /= norm
    return pin.XYZQUATToSE3(unit)


def se3_to_pose(transform: pin.SE3) -> FloatArray:
    """Convert `pin.SE3` to a pose (7,) with qw >= 0."""
    if not isinstance(transform, pin.SE3):
        raise InvalidValue("A transform", transform, "has to be a `pin.SE3`")
    pose = np.asarray(pin.SE3ToXYZQUAT(transform))
    if not pose[6] >= 0:
        pose[3:] *= -1.0
    return pose


def pose_to_matrix(pose: PoseLike) -> FloatArray:
    """Convert a pose (7,) to a homogeneous matrix (4, 4)."""
    return np.array(pose_to_se3(pose).homogeneous)


def matrix_to_pose(matrix: FloatArray) -> FloatArray:
    """Convert a homogeneous matrix (4, 4) to a pose (7,).

    Raises:
        InvalidValue: It has another shape, or no valid rotation (also a ValueError).
    """
    m = as_finite(as_array(matrix, "A matrix"), "A matrix")
    if m.shape != (4, 4) or not np.allclose(m[3], (0.0, 0.0, 0.0, 1.0), atol=1e-6):
        raise InvalidValue("A matrix", matrix, "has to have shape (4, 4) and the last row [0, 0, 0, 1]")
    if not np.allclose(m[:3, :3] @ m[:3, :3].T, np.eye(3), atol=1e-3) or np.linalg.det(m[:3, :3]) < 0.0:
        raise InvalidValue("A matrix", matrix, "has no rotation in its first three rows and columns")
    return se3_to_pose(pin.SE3(m))


def compose(*poses: PoseLike) -> FloatArray:
    """Return the product of poses: `compose(T_a_b, T_b_c)` is T_a_c; without arguments the identity."""
    if not poses:
        return IDENTITY.copy()
    result = pose_to_se3(poses[0])
    for pose in poses[1:]:
        result = result * pose_to_se3(pose)
    return se3_to_pose(result)


def inverse(pose: PoseLike) -> FloatArray:
    """Return T_b_a for T_a_b."""
    return se3_to_pose(pose_to_se3(pose).inverse())


def relative(pose: PoseLike, reference: PoseLike) -> FloatArray:
    """Return a world pose in the frame of a world pose `reference`: inverse(reference) * pose."""
    return se3_to_pose(pose_to_se3(reference).actInv(pose_to_se3(pose)))


def swept(pose: PoseLike, frame: PoseLike, axis: Sequence[float], angles: FloatArray, *, twist: bool = True) -> list[FloatArray]:
    """Rotate a world pose about an axis through the origin of a frame.

    Args:
        pose: The pose to rotate (7,).
        frame: World pose (7,) of the frame in which the axis is given.
        axis: Direction (3,), of any length.
        angles: Right-handed angles (m,), [rad].
        twist: Rotate the orientation too; otherwise only the position.

    Returns:
        A pose (7,) for each angle.

    Raises:
        InvalidValue: The pose or the axis is invalid, or a number is NaN (also a ValueError).
    """
    T_world_frame, T_world_pose = pose_to_se3(frame), pose_to_se3(pose)
    T_frame_pose = T_world_frame.actInv(T_world_pose)
    direction = as_vector(axis, 3, "axis")
    length = np.linalg.norm(direction)
    if not length > 0.0:
        raise InvalidValue("axis", axis, "has no direction: its length is 0")
    direction = direction / length
    result = []
    for angle in as_finite(as_array(angles, "angles"), "angles").ravel():
        T_turned = T_world_frame * (pin.SE3(pin.exp3(angle * direction), np.zeros(3)) * T_frame_pose)
        result.append(se3_to_pose(T_turned if twist else pin.SE3(T_world_pose.rotation, T_turned.translation)))
    return result


def euler_to_quaternion(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Return the quaternion [qx, qy, qz, qw] of the rotation Rz(yaw) Ry(pitch) Rx(roll), angles in [rad]."""
    roll, pitch, yaw = as_number(roll, "roll"), as_number(pitch, "pitch"), as_number(yaw, "yaw")
    return np.asarray(pin.Quaternion(pin.rpy.rpyToMatrix(roll, pitch, yaw)).coeffs())


def quaternion_yaw(quaternion: PoseLike) -> float:
    """Return the heading of the rotated x axis about world z [rad]."""
    q = as_vector(quaternion, 4, "A quaternion [qx, qy, qz, qw]")
    if not 0.0 < (norm := float(np.linalg.norm(q))) < np.inf:
        raise InvalidValue("A quaternion", quaternion, f"has norm {norm}", "The identity is [0, 0, 0, 1].")
    rotation = pin.Quaternion(q / norm).toRotationMatrix()
    return float(np.arctan2(rotation[1, 0], rotation[0, 0]))


def pose_at(position: Sequence[float], roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> FloatArray:
    """Return the pose (7,) of a position [m] and Euler angles [rad]."""
    return np.concatenate([as_vector(position, 3, "A position"), euler_to_quaternion(roll, pitch, yaw)])


def rotation_distance(a: PoseLike, b: PoseLike) -> float:
    """Return the angle [rad] between the orientations of two poses."""
    dot = abs(float(np.dot(as_pose(a)[3:], as_pose(b)[3:])))
    return 2.0 * float(np.arccos(min(1.0, dot)))


__all__ = [
    "IDENTITY",
    "TABLE_HEIGHT",
    "FloatArray",
    "PoseLike",
    "above_table",
    "compose",
    "euler_to_quaternion",
    "inverse",
    "matrix_to_pose",
    "pose_at",
    "pose_to_matrix",
    "pose_to_se3",
    "quaternion_yaw",
    "relative",
    "rotation_distance",
    "se3_to_pose",
    "swept",
]
