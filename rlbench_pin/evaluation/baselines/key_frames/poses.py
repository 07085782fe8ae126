"""Tip poses as a network sees them, a position and two axes, in a frame that goes with the scene or with a hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.spatial import FloatArray, matrix_to_pose, pose_to_matrix


@dataclass(frozen=True, eq=False)
class Frame:
    """Where a network looks from."""

    origin: FloatArray
    """In the world, (3,) [m]."""
    rotation: FloatArray
    """Its axes in the world as columns, (3, 3)."""

    @classmethod
    def of_tip(cls, pose: FloatArray) -> Frame:
        """Return the frame of a tip pose (7,)."""
        return cls(np.asarray(pose[:3], dtype=float), pose_to_matrix(pose)[:3, :3])

    def points(self, points: FloatArray) -> FloatArray:
        """Return points of the world (..., 3) in this frame."""
        moved: FloatArray = (points - self.origin) @ self.rotation
        return moved

    def axes(self, axes: FloatArray) -> FloatArray:
        """Return two axes (6,) of the world in this frame."""
        return (axes.reshape(2, 3) @ self.rotation).ravel()

    def pose(self, position: FloatArray, axes: FloatArray) -> FloatArray:
        """Return a tip pose in the world (7,) from position (3,) and axes (6,) in this frame."""
        return pose_from(self.rotation @ position + self.origin, (axes.reshape(2, 3) @ self.rotation.T).ravel())


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


def turn(vector: FloatArray) -> FloatArray:
    """Return the rotation about a vector by its length [rad], (3, 3) (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / max(angle, 1e-12)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
