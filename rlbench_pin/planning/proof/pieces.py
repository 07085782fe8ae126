"""Pieces of a path between parameters, which can be cut."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.planning.path import JointPath
from rlbench_pin.spatial import FloatArray


class Pieces:
    """Cubic pieces of a path.

    Args:
        path: The path.
        low: Parameters (m,) where they begin.
        high: Parameters (m,) where they end, with no knot between.
    """

    def __init__(self, path: JointPath, low: FloatArray, high: FloatArray) -> None:
        self._path, self.low, self.high = path, low, high
        control = path.bezier(low, high)
        self.middles = 0.125 * (control[:, 0] + 3.0 * (control[:, 1] + control[:, 2]) + control[:, 3])
        """Configurations in the middle of each (m, n), [rad]."""
        self.steps = control - self.middles[:, None]
        """Control points relative to the middle (m, 4, n), [rad]; the piece is in their hull."""
        self.turns = np.abs(self.steps).max(axis=1)
        """How far each joint turns from the middle at most (m, n), [rad]."""

    @classmethod
    def of(cls, path: JointPath) -> Pieces:
        """Return the path's own cubic pieces."""
        knots = path.knots
        return cls(path, knots[:-1], knots[1:])

    def cut(self, which: NDArray[np.intp], counts: NDArray[np.intp]) -> Pieces:
        """Return pieces `which` (k,) in `counts` (k,) even parts each, one after the other."""
        low, width = np.repeat(self.low[which], counts), np.repeat((self.high - self.low)[which] / counts, counts)
        part = np.arange(len(low)) - np.repeat(np.cumsum(counts) - counts, counts)
        last = part + 1 == np.repeat(counts, counts)
        return Pieces(
            self._path, low + part * width, np.where(last, np.repeat(self.high[which], counts), low + (part + 1) * width)
        )
