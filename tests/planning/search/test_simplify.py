"""Shorter polylines."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from rlbench_pin.planning.path import edge_is_free
from rlbench_pin.planning.search.simplify import leave_out, shorten

ZIGZAG = np.array([[0.0, 0.0], [0.2, 0.6], [0.4, -0.3], [0.6, 0.7], [0.8, 0.1], [1.0, 0.0]])


def length(path: np.ndarray) -> float:
    """Length of a polyline."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def outside_disc(q: np.ndarray) -> bool:
    """A disc on the straight way."""
    return bool(np.linalg.norm(q - [0.5, 0.0]) > 0.2)


def test_without_obstacles_only_the_ends_remain(rng: np.random.Generator) -> None:
    """The shortest path is the edge from start to goal."""
    np.testing.assert_array_equal(shorten(ZIGZAG, lambda q: True, rng), ZIGZAG[[0, -1]])
    np.testing.assert_array_equal(leave_out(ZIGZAG, lambda q: True, 0.05), ZIGZAG[[0, -1]])


def test_shortcuts_are_free_and_shorter(rng: np.random.Generator) -> None:
    """Around an obstacle the path comes near its shortest length and keeps clear."""
    detour = np.array([[0.0, 0.0], [0.0, 0.9], [1.0, 0.9], [1.0, 0.0]])
    path = shorten(detour, outside_disc, rng, step=0.01, checks=5000)
    assert all(edge_is_free(a, b, outside_disc, 0.01) for a, b in pairwise(path))
    assert length(path) < 0.6 * length(detour)
    np.testing.assert_array_equal(path[[0, -1]], detour[[0, -1]])


def test_the_budget_is_kept(rng: np.random.Generator) -> None:
    """No more checks are made than allowed, and the result is still free."""
    calls = 0

    def counted(q: np.ndarray) -> bool:
        nonlocal calls
        calls += 1
        return outside_disc(q)

    path = shorten(np.array([[0.0, 0.0], [0.0, 0.9], [1.0, 0.9], [1.0, 0.0]]), counted, rng, step=0.01, checks=150)
    assert calls <= 150
    assert all(edge_is_free(a, b, outside_disc, 0.01) for a, b in pairwise(path))
