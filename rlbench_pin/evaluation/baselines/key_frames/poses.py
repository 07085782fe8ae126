"""Tip poses as a network sees them: a position and two axes; and the turn of a scene about the vertical."""

from __future__ import annotations

import numpy as np

from rlbench_pin.spatial import FloatArray, matrix_to_pose, pose_to_matrix


def axes_of(pose: FloatArray) -> FloatArray:
    """Return the x and z axis of a tip pose (7,), shape (6,)."""
    rotation = pose_to_matrix(pose)[:3, :3]
    return np.concatenate([rotation[:, 0], rotation[:, 2]])


def pose_from(position: FloatArray, axes: FloatArray) -> FloatArray:
    """Return the tip pose (7,) nearest to a position and two axes that need not be orthonormal.

    The z axis, along which the hand points, is kept; the x axis is made orthogonal to it (Gram and Schmidt).
    """
    z = axes[3:] / max(float(np.linalg.norm(axes[3:])), 1e-9)
    x = axes[:3] - z * float(axes[:3] @ z)
    x = x / max(float(np.linalg.norm(x)), 1e-9)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.column_stack([x, np.cross(z, x), z]), position
    return matrix_to_pose(matrix)


def vertical_turn(angle: float) -> FloatArray:
    """Return the rotation by an angle [rad] about the vertical, (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
