"""Things that stand apart: connected parts of a cloud."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from rlbench_pin.evaluation.baselines.classical.perception.cloud import Cloud
from rlbench_pin.spatial import FloatArray

GAP = 0.012
"""Points nearer than this to each other belong together [m]."""
FEWEST = 25
"""Smaller clusters are dust."""


def clusters(cloud: Cloud, gap: float = GAP, fewest: int = FEWEST) -> list[Cloud]:
    """Return the connected parts of a cloud, the largest first."""
    if len(cloud) == 0:
        return []
    pairs = cKDTree(cloud.points).query_pairs(gap, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(cloud), len(cloud)))
    _, labels = connected_components(links, directed=False)
    sizes = np.bincount(labels)
    order = [label for label in np.argsort(-sizes, kind="stable") if sizes[label] >= fewest]
    return [cloud.where(labels == label) for label in order]


def rectangle(points: FloatArray) -> tuple[FloatArray, float, FloatArray]:
    """Return middle (2,) [m], yaw [rad] and sides (2,) [m] of the smallest upright rectangle around points (n, 2 or 3)."""
    flat, best = points[:, :2], (np.inf, 0.0)
    for yaw in np.linspace(0.0, np.pi / 2.0, 90, endpoint=False):
        sides = np.ptp(flat @ _turn(yaw), axis=0)
        best = min(best, (float(sides[0] * sides[1]), float(yaw)))
    turned = flat @ _turn(best[1])
    low, high = turned.min(axis=0), turned.max(axis=0)
    return _turn(best[1]) @ (0.5 * (low + high)), best[1], high - low


def _turn(yaw: float) -> FloatArray:
    """Return the matrix (2, 2) whose columns are the axes of a frame turned by `yaw` [rad]."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s], [s, c]])
