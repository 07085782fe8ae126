"""Pictures of several cameras as one small cloud of coloured points, with the neighbours of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from rlbench_pin.environment import ObservationConfig, picture_config
from rlbench_pin.errors import DatasetError
from rlbench_pin.observation import CAMERAS, Observation
from rlbench_pin.spatial import TABLE_HEIGHT

LOW, HIGH = np.array([-0.3, -0.5, TABLE_HEIGHT - 0.01]), np.array([0.7, 0.5, TABLE_HEIGHT + 1.0])
"""Corners of the box that is kept, in the world [m]."""
CELL = 0.01
"""Size of the grid of which each cell keeps one point [m]."""
POINTS = 768
"""Points of a cloud."""
NEIGHBOURS = 12
"""Nearest points that a point is told about."""
FLAT = 0.006
"""What is less high over the table counts as table [m]."""
TABLE_SHARE = 0.1
"""Share of the points that table may have."""
IMAGE_SIZE = (128, 128)
"""Width and height of the pictures [px]."""


@dataclass(frozen=True)
class Cloud:
    """What several cameras see together."""

    points: np.ndarray
    """Positions in the world, float32 (POINTS, 3) [m]."""
    colors: np.ndarray
    """Red, green, blue 0..1, float32 (POINTS, 3)."""
    neighbours: np.ndarray
    """Numbers of the nearest points, itself first, int64 (POINTS, NEIGHBOURS)."""


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


def make_cloud(observation: Observation, cameras: Sequence[str] = CAMERAS) -> Cloud:
    """Fuse the pictures of an observation: crop, one point per cell, few of the table, a fixed number.

    Nothing is drawn at random: the same pictures give the same cloud.

    Raises:
        DatasetError: A camera lacks colours or points, or nothing is seen in the box.
    """
    pairs = [(getattr(observation, f"{c}_point_cloud", None), getattr(observation, f"{c}_rgb", None)) for c in cameras]
    if any(p is None or c is None for p, c in pairs):
        raise DatasetError(f"An observation lacks colours or point clouds of one of {list(cameras)}. See `cloud_config`.")
    points = np.concatenate([np.asarray(p, dtype=np.float32).reshape(-1, 3) for p, _ in pairs])
    colors = np.concatenate([np.asarray(c).reshape(-1, 3) for _, c in pairs])
    inside = ((points > LOW) & (points < HIGH)).all(axis=1)
    points, colors = points[inside], colors[inside]
    if len(points) == 0:
        raise DatasetError("No camera sees anything above the table, so there is no cloud.")
    cells = np.floor((points - LOW) / CELL).astype(np.int64) @ np.array([1, 1_000, 1_000_000])
    _, first = np.unique(cells, return_index=True)
    rows = _chosen(first, points[first, 2] < TABLE_HEIGHT + FLAT)
    chosen = np.ascontiguousarray(points[rows], dtype=np.float32)
    return Cloud(chosen, colors[rows].astype(np.float32) / 255.0, neighbours(chosen))


def _chosen(rows: np.ndarray, is_table: np.ndarray) -> np.ndarray:
    """Return `POINTS` of the rows, spread evenly, a share of them at most from the table; repeated where there are too few."""
    rng = np.random.default_rng(0)
    things, table = rng.permutation(rows[~is_table]), rng.permutation(rows[is_table])
    of_table = min(len(table), max(int(POINTS * TABLE_SHARE), POINTS - len(things)))
    kept = np.concatenate([things[: POINTS - of_table], table[:of_table]])
    return np.resize(kept, POINTS)


def neighbours(points: np.ndarray, count: int = NEIGHBOURS) -> np.ndarray:
    """Return the numbers of the nearest points of each point, nearest first, int64 (n, count)."""
    tensor = torch.as_tensor(points, dtype=torch.float32)
    return torch.cdist(tensor, tensor).topk(count, largest=False).indices.numpy()
