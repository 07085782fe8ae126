"""Reading and setting places: positions, Euler angles, quaternions, poses, matrices."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from rlbench_pin.compat.things import Thing
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.spatial import FloatArray, compose, matrix_to_pose, pose_to_matrix, relative


class InvalidPlace(RlbenchPinError, ValueError):
    """Numbers that are no place: wrong count, NaN, or a quaternion whose length is not 1."""


class PoseMethods(ABC):
    """Places of a thing, in the world or in the frame of another thing."""

    @property
    @abstractmethod
    def thing(self) -> Thing:
        """What answers for it in the world now."""

    def get_pose(self, relative_to: PoseMethods | None = None) -> FloatArray:
        """Return the pose (7,): x, y, z [m], qx, qy, qz, qw.

        Args:
            relative_to: In whose frame; None is the world.
        """
        pose = self.thing.pose
        return pose if relative_to is None else relative(pose, relative_to.get_pose())

    def set_pose(
        self, pose: Sequence[float] | FloatArray, relative_to: PoseMethods | None = None, reset_dynamics: bool = True
    ) -> None:
        """Move to a pose (7,).

        Args:
            pose: x, y, z [m], qx, qy, qz, qw.
            relative_to: In whose frame; None is the world.
            reset_dynamics: Bring it to rest as well.
        """
        numbers = _numbers(pose, 7, "pose")
        norm = float(np.linalg.norm(numbers[3:]))
        if abs(norm - 1.0) > 1e-2:
            raise InvalidPlace(f"The quaternion {numbers[3:].tolist()} has length {norm:.4f}, not 1. The order is x, y, z, w.")
        numbers[3:] /= norm
        there = numbers if relative_to is None else compose(relative_to.get_pose(), numbers)
        self.thing.set_pose(there, reset_dynamics)

    def get_position(self, relative_to: PoseMethods | None = None) -> FloatArray:
        """Return the position (3,) [m]."""
        return self.get_pose(relative_to)[:3]

    def set_position(
        self, position: Sequence[float] | FloatArray, relative_to: PoseMethods | None = None, reset_dynamics: bool = True
    ) -> None:
        """Move to a position (3,) [m]; the orientation stays."""
        pose = np.concatenate([_numbers(position, 3, "position"), self.get_pose(relative_to)[3:]])
        self.set_pose(pose, relative_to, reset_dynamics)

    def get_quaternion(self, relative_to: PoseMethods | None = None) -> FloatArray:
        """Return the orientation (4,): qx, qy, qz, qw."""
        return self.get_pose(relative_to)[3:]

    def set_quaternion(
        self, quaternion: Sequence[float] | FloatArray, relative_to: PoseMethods | None = None, reset_dynamics: bool = True
    ) -> None:
        """Turn to an orientation (4,): qx, qy, qz, qw; the position stays."""
        pose = np.concatenate([self.get_pose(relative_to)[:3], _numbers(quaternion, 4, "quaternion")])
        self.set_pose(pose, relative_to, reset_dynamics)

    def get_orientation(self, relative_to: PoseMethods | None = None) -> FloatArray:
        """Return Euler angles (3,) [rad] with R = Rx(a) Ry(b) Rz(c)."""
        return matrix_to_euler(self.get_matrix(relative_to)[:3, :3])

    def set_orientation(
        self, orientation: Sequence[float] | FloatArray, relative_to: PoseMethods | None = None, reset_dynamics: bool = True
    ) -> None:
        """Turn to Euler angles (3,) [rad] with R = Rx(a) Ry(b) Rz(c); the position stays."""
        matrix = np.eye(4)
        matrix[:3, :3] = euler_to_matrix(_numbers(orientation, 3, "orientation"))
        self.set_quaternion(matrix_to_pose(matrix)[3:], relative_to, reset_dynamics)

    def get_matrix(self, relative_to: PoseMethods | None = None) -> FloatArray:
        """Return the homogeneous matrix (4, 4) from its own to world coordinates."""
        return pose_to_matrix(self.get_pose(relative_to))

    def set_matrix(self, matrix: FloatArray, relative_to: PoseMethods | None = None, reset_dynamics: bool = True) -> None:
        """Move to where a homogeneous matrix (4, 4), or its first three rows, says."""
        full = np.eye(4)
        numbers = np.asarray(matrix, dtype=float)
        if numbers.size not in (12, 16) or not np.isfinite(numbers).all():
            raise InvalidPlace(f"A matrix has shape (4, 4) or (3, 4) and finite numbers, not shape {numbers.shape}.")
        full[:3] = numbers.reshape(-1, 4)[:3]
        self.set_pose(matrix_to_pose(full), relative_to, reset_dynamics)

    def rotate(self, rotation: Sequence[float] | FloatArray) -> None:
        """Turn about its own x axis, then y, then z, by angles (3,) [rad]; the axes are those before the turn."""
        a, b, c = _numbers(rotation, 3, "rotation")
        turn = np.eye(4)
        turn[:3, :3] = euler_to_matrix((0.0, 0.0, c)) @ euler_to_matrix((0.0, b, 0.0)) @ euler_to_matrix((a, 0.0, 0.0))
        self.set_pose(compose(self.get_pose(), matrix_to_pose(turn)))

    def set_place(self, position: Sequence[float] | FloatArray | None, orientation: Sequence[float] | FloatArray | None) -> None:
        """Set position (3,) [m] and Euler angles (3,) [rad], where they are given."""
        if position is not None:
            self.set_position(position)
        if orientation is not None:
            self.set_orientation(orientation)

    def reset_dynamic_object(self) -> None:
        """Bring it to rest where it is."""
        self.set_pose(self.get_pose())


def euler_to_matrix(angles: Sequence[float] | FloatArray) -> FloatArray:
    """Return the rotation (3, 3) Rx(a) Ry(b) Rz(c) of angles (3,) [rad]."""
    (sa, sb, sc), (ca, cb, cc) = np.sin(angles), np.cos(angles)
    x = np.array([[1.0, 0.0, 0.0], [0.0, ca, -sa], [0.0, sa, ca]])
    y = np.array([[cb, 0.0, sb], [0.0, 1.0, 0.0], [-sb, 0.0, cb]])
    z = np.array([[cc, -sc, 0.0], [sc, cc, 0.0], [0.0, 0.0, 1.0]])
    product: FloatArray = x @ y @ z
    return product


def matrix_to_euler(rotation: FloatArray) -> FloatArray:
    """Return the angles (3,) [rad] of a rotation (3, 3) = Rx(a) Ry(b) Rz(c); c is 0 where only a + c or a - c counts."""
    b = float(np.arcsin(np.clip(rotation[0, 2], -1.0, 1.0)))
    if abs(rotation[0, 2]) > 1.0 - 1e-9:
        return np.array([np.arctan2(rotation[2, 1], rotation[1, 1]), b, 0.0])
    return np.array([np.arctan2(-rotation[1, 2], rotation[2, 2]), b, np.arctan2(-rotation[0, 1], rotation[0, 0])])


def _numbers(values: Sequence[float] | FloatArray, count: int, what: str) -> FloatArray:
    numbers = np.array(values, dtype=float)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise InvalidPlace(f"A {what} has {count} finite numbers, not {numbers.tolist()}.")
    return numbers
