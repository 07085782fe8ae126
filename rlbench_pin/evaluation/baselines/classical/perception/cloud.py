"""Depth pictures -> one coloured cloud of what stands on the table, without table and arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from rlbench_pin.evaluation.baselines.sight.arm import arm_surface
from rlbench_pin.observation import Observation
from rlbench_pin.robot import RobotModel
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

CAMERAS = ("left_shoulder", "right_shoulder", "overhead", "wrist", "front")
"""The cameras that are looked through."""
LOWEST, HIGHEST = np.array([-0.1, -0.85, -0.003]), np.array([1.1, 0.85, 0.9])
"""Corners of the box over the table in which things are looked for; heights count from the table [m]."""
FLAT = 0.003
"""What is lower than this belongs to the plane of the table [m]."""
OWN = 0.03
"""Points nearer than this to the arm's own surface are taken for the arm [m]."""
VOXEL = 0.003
"""One point is kept of each cube of this side [m]."""


@dataclass(frozen=True, eq=False)
class Cloud:
    """Coloured points in the world."""

    points: FloatArray
    """Shape (n, 3) [m]."""
    colors: FloatArray
    """Red, green, blue from 0 to 1, shape (n, 3)."""

    def __len__(self) -> int:
        return len(self.points)

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Cloud:
        """Return the points that a mask (n,) or indices choose."""
        return Cloud(self.points[chosen], self.colors[chosen])

    def between(self, low: float, high: float) -> Cloud:
        """Return what is between two heights over the table [m]."""
        height = self.points[:, 2] - TABLE_HEIGHT
        return self.where((height >= low) & (height < high))

    @property
    def middle(self) -> FloatArray:
        """Middle of the axis-aligned box around the points (3,) [m]."""
        middle: FloatArray = 0.5 * (self.points.min(axis=0) + self.points.max(axis=0))
        return middle

    @property
    def size(self) -> FloatArray:
        """Sides of that box (3,) [m]."""
        return np.ptp(self.points, axis=0)


@dataclass(frozen=True, eq=False)
class View:
    """What is seen at one instant, taken apart."""

    things: Cloud
    """What stands on the table or floats above it."""
    marks: Cloud
    """The plane of the table, with what is painted on it."""


def back_project(depth: FloatArray, intrinsics: FloatArray, extrinsics: FloatArray) -> FloatArray:
    """Return the world coordinates of every pixel, shape (h * w, 3) [m].

    Args:
        depth: Along the optical axis (h, w) [m].
        intrinsics: Camera to pixel (3, 3).
        extrinsics: Camera to world (4, 4).
    """
    height, width = depth.shape
    v, u = np.mgrid[0:height, 0:width] + 0.5
    rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3) @ np.linalg.inv(intrinsics).T
    points: FloatArray = (rays * depth.reshape(-1, 1)) @ extrinsics[:3, :3].T + extrinsics[:3, 3]
    return points


def look(observation: Observation, arm: RobotModel) -> View:
    """Return what the cameras of an observation see, merged.

    Args:
        observation: Colours and depth [m] of cameras, joint positions, and the positions of the fingers.
        arm: Model of the arm, to leave out its own points.
    """
    clouds = [cloud for name in CAMERAS if (cloud := _seen_by(observation, name)) is not None]
    merged = thinned(Cloud(np.concatenate([c.points for c in clouds]), np.concatenate([c.colors for c in clouds])))
    own = arm_surface(arm, np.asarray(observation.joint_positions), np.asarray(observation.gripper_joint_positions))
    height = merged.points[:, 2] - TABLE_HEIGHT
    apart = cKDTree(own).query(merged.points, distance_upper_bound=OWN)[0] > OWN
    return View(merged.where(apart & (height > FLAT)), merged.where(apart & (height <= FLAT)))


def thinned(cloud: Cloud, voxel: float = VOXEL) -> Cloud:
    """Keep one point of each cube of side `voxel` [m]."""
    cells = np.floor(cloud.points / voxel).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    return cloud.where(np.sort(first))


def _seen_by(observation: Observation, name: str) -> Cloud | None:
    """Return what one camera sees in the box over the table; None when it is switched off."""
    depth, rgb = getattr(observation, f"{name}_depth", None), getattr(observation, f"{name}_rgb", None)
    if depth is None or rgb is None:
        return None
    misc = observation.misc
    points = back_project(depth, misc[f"{name}_camera_intrinsics"], misc[f"{name}_camera_extrinsics"])
    local = points - (0.0, 0.0, TABLE_HEIGHT)
    inside = ((local > LOWEST) & (local < HIGHEST)).all(axis=1)
    return Cloud(points[inside], rgb.reshape(-1, 3)[inside] / 255.0)
