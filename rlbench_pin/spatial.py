"""The pose conventions, said once.

A pose is a float64 array of shape (7,): `[x, y, z, qx, qy, qz, qw]`, metres and a unit Hamilton quaternion, w last.
`T_a_b` maps coordinates of frame b to frame a, so inner names cancel: `T_world_tip = T_world_base * T_base_tip`.
Inside the package poses may travel as `pin.SE3`; at public borders they are arrays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.errors import InvalidValue

FloatArray = NDArray[np.float64]
PoseLike = Sequence[float] | FloatArray

TABLE_HEIGHT = 0.752
"""Height of the table top above the floor, the origin of the world [m]."""


def above_table(height: float) -> float:
    """Return the world z [m] of what is `height` [m] above the table top, without float dust."""
    return round(TABLE_HEIGHT + height, 12)


IDENTITY: FloatArray = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
IDENTITY.setflags(write=False)


def pose_to_se3(pose: PoseLike) -> pin.SE3:
    """Convert a pose (7,) to `pin.SE3`; the quaternion is normalised.

    Raises:
        InvalidValue: It has another shape, or its quaternion is zero or not finite (also a ValueError).
    """
    p = np.asarray(pose, dtype=float)
    if p.shape != (7,):
        raise InvalidValue("A pose", pose, f"has to have shape (7,), not {p.shape}", "Write [x, y, z, qx, qy, qz, qw].")
    quaternion = p[3:]
    norm = math.sqrt(quaternion.dot(quaternion))
    if norm == 1.0:
        return pin.XYZQUATToSE3(p)
    if not 0.0 < norm < math.inf:
        raise InvalidValue(
            "A pose", pose, f"has a quaternion of norm {norm}", "No rotation is [0, 0, 0, 1]; the order is x, y, z, w."
        )
    return pin.XYZQUATToSE3(np.concatenate([p[:3], quaternion / norm]))


def se3_to_pose(transform: pin.SE3) -> FloatArray:
    """Convert `pin.SE3` to a pose (7,) with qw >= 0."""
    pose = np.asarray(pin.SE3ToXYZQUAT(transform))
    return pose if pose[6] >= 0 else np.concatenate([pose[:3], -pose[3:]])


def pose_to_matrix(pose: PoseLike) -> FloatArray:
    """Convert a pose (7,) to a homogeneous matrix (4, 4)."""
    return np.array(pose_to_se3(pose).homogeneous)


def matrix_to_pose(matrix: FloatArray) -> FloatArray:
    """Convert a homogeneous matrix (4, 4) to a pose (7,)."""
    return se3_to_pose(pin.SE3(np.asarray(matrix, dtype=float)))


def compose(*poses: PoseLike) -> FloatArray:
    """Chain poses: `compose(T_a_b, T_b_c)` is T_a_c."""
    result = pose_to_se3(poses[0])
    for pose in poses[1:]:
        result = result * pose_to_se3(pose)
    return se3_to_pose(result)


def inverse(pose: PoseLike) -> FloatArray:
    """Return T_b_a for T_a_b."""
    return se3_to_pose(pose_to_se3(pose).inverse())


def relative(pose: PoseLike, reference: PoseLike) -> FloatArray:
    """Express a world pose in the frame of a world `reference`: inverse(reference) * pose."""
    return se3_to_pose(pose_to_se3(reference).actInv(pose_to_se3(pose)))


def euler_to_quaternion(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Quaternion [qx, qy, qz, qw] of the rotation Rz(yaw) Ry(pitch) Rx(roll), angles in [rad]."""
    return np.asarray(pin.Quaternion(pin.rpy.rpyToMatrix(roll, pitch, yaw)).coeffs())


def quaternion_yaw(quaternion: PoseLike) -> float:
    """Heading of the rotated x axis about world z [rad]."""
    rotation = pin.Quaternion(np.asarray(quaternion, dtype=float)).toRotationMatrix()
    return float(np.arctan2(rotation[1, 0], rotation[0, 0]))


def pose_at(position: Sequence[float], roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> FloatArray:
    """Build a pose (7,) from a position [m] and Euler angles [rad]."""
    return np.concatenate([np.asarray(position, dtype=float), euler_to_quaternion(roll, pitch, yaw)])


def rotation_distance(a: PoseLike, b: PoseLike) -> float:
    """Angle [rad] between the orientations of two poses."""
    dot = abs(float(np.dot(np.asarray(a)[3:], np.asarray(b)[3:])))
    return 2.0 * float(np.arccos(min(1.0, dot)))
