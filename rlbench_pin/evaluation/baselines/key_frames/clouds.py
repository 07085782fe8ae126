"""Pictures of several cameras as one cloud of coloured points, without the arm and nearly without table; and samples of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from rlbench_pin.environment import ObservationConfig, picture_config
from rlbench_pin.errors import DatasetError
from rlbench_pin.evaluation.baselines.sight import arm_surface
from rlbench_pin.observation import CAMERAS, Observation
from rlbench_pin.robot import RobotModel
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray

LOW, HIGH = np.array([-0.3, -0.5, TABLE_HEIGHT - 0.01]), np.array([0.7, 0.5, TABLE_HEIGHT + 1.0])
"""Corners of the box that is kept, in the world [m]."""
CELL = 0.005
"""Size of the grid of which each cell keeps one point [m]."""
OWN = 0.015
"""Points nearer than this to the arm's own surface are taken for the arm [m]."""
FLAT = 0.003
"""What is less high over the table counts as table [m]."""
TABLE_SHARE = 0.1
"""Points of the table that are kept, as a share of the others."""
IMAGE_SIZE = (256, 256)
"""Width and height of the pictures [px]."""


@dataclass(frozen=True)
class Cloud:
    """Coloured points in the world."""

    points: np.ndarray
    """Positions, float32 (n, 3) [m]."""
    colors: np.ndarray
    """Red, green, blue, uint8 (n, 3)."""

    def __len__(self) -> int:
        return len(self.points)

    def where(self, rows: np.ndarray) -> Cloud:
        """Return some of the points, in the order of their numbers `rows`."""
        return Cloud(self.points[rows], self.colors[rows])


def cloud_config() -> ObservationConfig:
    """Return what has to be observed for a cloud: colours and points of the five cameras, joints, hand and tip."""
    config = picture_config(IMAGE_SIZE, CAMERAS, depth=False, mask=False)
    switch_cameras(config, True)
    return config


def switch_cameras(config: ObservationConfig, on: bool) -> None:
    """Ask for colours and points of the five cameras, or for no picture at all."""
    config.set_all_high_dim(False)
    for camera in config.cameras().values():
        camera.rgb = camera.point_cloud = on


def make_cloud(observation: Observation, arm: RobotModel, cameras: Sequence[str] = CAMERAS) -> Cloud:
    """Fuse the pictures of an observation: crop, one point per cell, no arm, little table.

    Nothing is drawn at random: the same pictures give the same cloud.

    Args:
        observation: Colours and points of the cameras, positions of joints and fingers.
        arm: Model of the arm, to leave out its own points.
        cameras: Their names.

    Raises:
        DatasetError: A camera lacks colours or points, or nothing is seen in the box.
    """
    pairs = [(getattr(observation, f"{c}_point_cloud", None), getattr(observation, f"{c}_rgb", None)) for c in cameras]
    if any(p is None or c is None for p, c in pairs):
        raise DatasetError(f"An observation lacks colours or point clouds of one of {list(cameras)}. See `cloud_config`.")
    points = np.concatenate([np.asarray(p, dtype=np.float32).reshape(-1, 3) for p, _ in pairs])
    colors = np.concatenate([np.asarray(c, dtype=np.uint8).reshape(-1, 3) for _, c in pairs])
    inside = np.flatnonzero(((points > LOW) & (points < HIGH)).all(axis=1))
    rows = inside[thinned(points[inside], CELL)]
    own = arm_surface(arm, np.asarray(observation.joint_positions), np.asarray(observation.gripper_joint_positions))
    rows = rows[cKDTree(own).query(points[rows], distance_upper_bound=OWN)[0] > OWN]
    if len(rows) == 0:
        raise DatasetError("No camera sees anything above the table but the arm, so there is no cloud.")
    is_table = points[rows, 2] < TABLE_HEIGHT + FLAT
    things, table = rows[~is_table], np.random.default_rng(0).permutation(rows[is_table])
    return Cloud(points, colors).where(np.concatenate([things, table[: max(100, int(len(things) * TABLE_SHARE))]]))


def thinned(points: FloatArray, cell: float) -> np.ndarray:
    """Return the numbers of the points of which each is the first in its cell of a grid [m]."""
    cells = np.floor((points - LOW) / cell).astype(np.int64) @ np.array([1, 10_000, 100_000_000])
    return np.unique(cells, return_index=True)[1]


def near(points: FloatArray, middle: FloatArray, radius: float, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return the numbers of `count` points: some of those in a ball, spread evenly, or else the nearest; repeated if too few."""
    far = np.linalg.norm(points - middle, axis=1)
    inside = np.flatnonzero(far < radius)
    if len(inside) >= count:
        return rng.permutation(inside)[:count]
    return np.resize(np.argsort(far)[:count], count)
