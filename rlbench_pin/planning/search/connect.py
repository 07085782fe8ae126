"""RRT-Connect (Kuffner, LaValle 2000) with edges walked configuration by configuration, kept as far as they are free.

Two trees grow towards each other, one from the start, one from all goals. Written for collision checks that cost some
microseconds: trees are arrays, the nearest node is one product, the smaller tree grows, samples are drawn in batches. (Edges that
shrink where they fail were tried: the 95th percentile became twenty times longer.)
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from rlbench_pin.planning.path import IsFree, coarse_to_fine
from rlbench_pin.spatial import FloatArray

_DRAWS = 64


class OutOfBudget(Exception):
    """The last collision check was spent."""


class _Tree:
    """Configurations and where each was reached from."""

    def __init__(self, roots: FloatArray) -> None:
        self.nodes = np.empty((256, roots.shape[1]))
        self.squares = np.empty(256)
        self.parents: list[int] = []
        for q in roots:
            self.add(q, -1)

    def add(self, q: FloatArray, parent: int) -> int:
        index = len(self.parents)
        if index == len(self.nodes):
            self.nodes = np.concatenate([self.nodes, np.empty_like(self.nodes)])
            self.squares = np.concatenate([self.squares, np.empty_like(self.squares)])
        self.nodes[index], self.squares[index] = q, q @ q
        self.parents.append(parent)
        return index

    def nearest(self, q: FloatArray) -> int:
        count = len(self.parents)
        return int(np.argmin(self.squares[:count] - 2.0 * (self.nodes[:count] @ q)))

    def branch(self, index: int) -> list[FloatArray]:
        """Return the configurations from a node back to its root."""
        result = []
        while index >= 0:
            result.append(self.nodes[index].copy())
            index = self.parents[index]
        return result


class Connector:
    """One search. Budgets are counted in collision checks, never in seconds."""

    def __init__(self, is_free: IsFree, *, checks: int, step: float, reach: float) -> None:
        """Prepare a search.

        Args:
            is_free: Collision check.
            checks: Budget of collision checks.
            step: Resolution of edge checks, in the norm of all joints [rad].
            reach: Longest edge [rad].
        """
        self.is_free, self.left, self.step, self.reach = is_free, checks, step, reach

    def search(
        self, q_start: FloatArray, goals: FloatArray, lower: FloatArray, upper: FloatArray, rng: np.random.Generator
    ) -> FloatArray | None:
        """Return a path (m, n) from `q_start` to one of `goals` (k, n), or None when the budget is spent."""
        trees = _Tree(q_start[None]), _Tree(goals)
        grown, drawn, samples = 0, 0, np.empty((0, len(lower)))
        try:
            while True:
                if drawn == len(samples):
                    samples, drawn = rng.uniform(lower, upper, (_DRAWS, len(lower))), 0
                target, drawn = samples[drawn], drawn + 1
                node = self._extend(trees[grown], target)
                if node is not None:
                    other = trees[1 - grown]
                    met = self._connect(other, trees[grown].nodes[node].copy())
                    if met is not None:
                        ends = (node, met) if grown == 0 else (met, node)
                        return np.array(trees[0].branch(ends[0])[::-1] + trees[1].branch(ends[1])[1:])
                if len(trees[1 - grown].parents) < len(trees[grown].parents):
                    grown = 1 - grown
        except OutOfBudget:
            return None

    def _extend(self, tree: _Tree, target: FloatArray) -> int | None:
        """Grow from the nearest node towards `target` by at most `reach`; None when blocked."""
        near = tree.nearest(target)
        a = tree.nodes[near]
        way = target - a
        distance = math.sqrt(way @ way)
        if self.reach < distance:
            way *= self.reach / distance
            distance = self.reach
        return tree.add(a + way, near) if self._edge(a, way, distance) else None

    def _connect(self, tree: _Tree, target: FloatArray) -> int | None:
        """Grow from the nearest node all the way to `target`, keeping what is free; return the node there."""
        near = tree.nearest(target)
        while True:
            a = tree.nodes[near]
            way = target - a
            distance = math.sqrt(way @ way)
            last = distance <= self.reach
            if not last:
                way *= self.reach / distance
                distance = self.reach
            if not self._edge(a, way, distance):
                return None
            near = tree.add(target if last else a + way, near)
            if last:
                return near

    def _edge(self, a: FloatArray, way: FloatArray, length: float) -> bool:
        """Say whether the line of a length from free `a` along `way` is free, its end included."""
        for q in a + _shares(int(length / self.step) + 2) * way:
            self.left -= 1
            if self.left < 0:
                raise OutOfBudget
            if not self.is_free(q):
                return False
        return True


@lru_cache(maxsize=1024)
def _shares(count: int) -> FloatArray:
    """Return where all but the first of `count` even samples of an edge are (count - 1, 1), widely spaced ones first, 0..1."""
    shares = np.array([i for i in coarse_to_fine(count) if i > 0])[:, None] * (1.0 / (count - 1))
    shares.flags.writeable = False
    return shares
