"""Oriented boxes: geometry for placement."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from rlbench_pin.robot.distances import cross
from rlbench_pin.spatial import FloatArray, compose, pose_at, pose_to_se3

_CORNERS: FloatArray = np.array(list(product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True, eq=False)
class OrientedBox:
    """A box in the world.

    `center` (3,) [m], `axes` (3, 3) with the directions of the edges as columns, `half` (3,) half edge lengths [m].
    """

    center: FloatArray
    axes: FloatArray
    half: FloatArray

    @classmethod
    def of(cls, bounds: FloatArray, pose: FloatArray) -> OrientedBox:
        """Return the box with lowest and highest local corner `bounds` (2, 3) [m] at a world pose (7,)."""
        low, high = np.asarray(bounds, dtype=float)
        transform = pose_to_se3(pose)
        return cls(transform.act((low + high) / 2.0), np.array(transform.rotation), (high - low) / 2.0)

    def corners(self) -> FloatArray:
        """Return the corners, shape (8, 3) [m]."""
        return self.center + (_CORNERS * self.half) @ self.axes.T

    def overlaps(self, other: OrientedBox) -> bool:
        """Return whether two boxes overlap: no axis separates them."""
        if math.dist(self.middle, other.middle) > self.radius + other.radius:
            return False
        way, turned = other.center - self.center, np.abs(self.axes.T @ other.axes)
        if np.any(np.abs(way @ self.axes) > self.half + turned @ other.half):
            return False
        if np.any(np.abs(way @ other.axes) > other.half + self.half @ turned):
            return False
        crossed = cross(np.repeat(self.axes.T, 3, axis=0), np.tile(other.axes.T, (3, 1)))
        axes = crossed[(crossed * crossed).sum(axis=1) > 1e-18]
        reach = np.abs(axes @ self.axes) @ self.half + np.abs(axes @ other.axes) @ other.half
        return bool(np.all(np.abs(axes @ way) <= reach))

    @cached_property
    def middle(self) -> list[float]:
        """The centre as plain numbers, for fast comparisons [m]."""
        return self.center.tolist()

    @cached_property
    def radius(self) -> float:
        """Radius of the bounding sphere of the box [m]."""
        return math.sqrt(self.half @ self.half)


def rotated(rotation: FloatArray, quaternion: FloatArray) -> FloatArray:
    """Rotate an orientation by roll, pitch, yaw [rad] about the axes of its reference frame."""
    turn = pose_at((0.0, 0.0, 0.0), *rotation)
    return compose(turn, np.concatenate([np.zeros(3), quaternion]))[3:]
