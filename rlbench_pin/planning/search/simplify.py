"""Shorter polylines: leave out vertices and cut corners as long as the shortcut is free."""

from __future__ import annotations

import math
from bisect import bisect_right

import numpy as np

from rlbench_pin.planning.path import IsFree, edge_is_free
from rlbench_pin.spatial import FloatArray


class _Counted:
    """A collision check that reports a collision once its budget is spent."""

    def __init__(self, is_free: IsFree, checks: int) -> None:
        self._is_free, self.left = is_free, checks

    def __call__(self, q: FloatArray) -> bool:
        self.left -= 1
        return self.left >= 0 and self._is_free(q)


def shorten(path: FloatArray, is_free: IsFree, rng: np.random.Generator, *, step: float = 0.05, checks: int = 600) -> FloatArray:
    """Shorten a free polyline (m, n) with at most `checks` collision checks; its ends stay.

    Args:
        path: Vertices with free edges, [rad].
        is_free: Collision check.
        rng: Draws where corners are cut.
        step: Resolution of edge checks [rad].
        checks: Budget.
    """
    counted = _Counted(is_free, checks)
    path = leave_out(path, counted, step)
    misses, along = 0, _along(path)
    while counted.left > 0 and misses < 12 and len(path) > 2:
        shorter = _cut(path, along, counted, rng, step)
        misses = misses + 1 if shorter is None else 0
        if shorter is not None:
            path, along = shorter, _along(shorter)
    return leave_out(path, counted, step)


def leave_out(path: FloatArray, is_free: IsFree, step: float) -> FloatArray:
    """Connect each vertex to the farthest later one that it sees, from the start on."""
    kept = [0]
    while kept[-1] < len(path) - 1:
        here = kept[-1]
        there = len(path) - 1
        while there > here + 1 and not edge_is_free(path[here], path[there], is_free, step):
            there = here + 1 + (there - here - 1) // 2 if there - here > 2 else here + 1
        kept.append(there)
    return path[kept]


def _along(path: FloatArray) -> tuple[list[float], list[float]]:
    """Return the length of each edge of a polyline (m, n), and the way to each of its vertices, [rad]."""
    way = np.diff(path, axis=0)
    lengths = np.sqrt((way * way).sum(axis=1))
    return lengths.tolist(), [0.0, *np.cumsum(lengths).tolist()]


def _cut(
    path: FloatArray, along: tuple[list[float], list[float]], is_free: IsFree, rng: np.random.Generator, step: float
) -> FloatArray | None:
    """Try to replace the part between two random points of the polyline by one edge; None when nothing is gained."""
    lengths, total = along
    low, high = sorted((total[-1] * rng.random(), total[-1] * rng.random()))
    i, j = (bisect_right(total, where, hi=len(lengths)) - 1 for where in (low, high))
    if i == j:
        return None
    a = path[i] + (low - total[i]) / lengths[i] * (path[i + 1] - path[i])
    b = path[j] + (high - total[j]) / lengths[j] * (path[j + 1] - path[j])
    way = b - a
    if math.sqrt(way @ way) > 0.98 * (high - low) or not edge_is_free(a, b, is_free, step):
        return None
    return np.concatenate([path[: i + 1], [a, b], path[j + 1 :]])
