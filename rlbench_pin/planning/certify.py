"""Proof that a motion is free between the checked configurations too (after Schwarzer, Saha, Latombe 2005).

A path is a sequence of Bezier pieces. No configuration of a piece is farther from its middle, joint by joint, than one of its
control points, so that no point of the arm, or of what it holds, moves away from where it is in the middle by more than

    D = sum_j r_j max_k |b_kj - m_j|                                                          (1)

with r_j the farthest that anything carried can be from the axis of joint j. If nothing is nearer than D in the middle, the
whole piece is free. That holds for two links as well: joints below both turn them alike, and those in between move only the
farther one. Where something is nearer than D, the piece is cut in two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.planning.path import JointPath
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import LARGEST_COUNT, as_record, as_whole

LEVELS = (0.05, 0.02, 0.008, 0.003, 0.001, 0.0003)
"""Distances that are asked for, one after the other [m]."""


@dataclass(frozen=True)
class Certificate:
    """What was proven of a path."""

    doubt: float | None
    """Where on the path (0..1) nothing could be proven; None when all of it is free."""
    checks: int
    """Configurations that were checked."""


@dataclass(eq=False)
class _Pieces:
    """Control points (m, 4, n) with the parameters (m,) of both ends."""

    control: FloatArray
    low: FloatArray
    high: FloatArray

    def __len__(self) -> int:
        return len(self.low)

    def __getitem__(self, which: NDArray[np.bool_]) -> _Pieces:
        return _Pieces(self.control[which], self.low[which], self.high[which])

    def with_(self, other: _Pieces) -> _Pieces:
        return _Pieces(
            np.concatenate([self.control, other.control]),
            np.concatenate([self.low, other.low]),
            np.concatenate([self.high, other.high]),
        )

    def middles(self) -> FloatArray:
        b = self.control
        return 0.125 * (b[:, 0] + 3.0 * (b[:, 1] + b[:, 2]) + b[:, 3])

    def halves(self) -> _Pieces:
        """Cut every piece in the middle (de Casteljau)."""
        b0, b1, b2, b3 = np.moveaxis(self.control, 1, 0)
        c0, c1, c2 = 0.5 * (b0 + b1), 0.5 * (b1 + b2), 0.5 * (b2 + b3)
        d0, d1 = 0.5 * (c0 + c1), 0.5 * (c1 + c2)
        middle, at = 0.5 * (d0 + d1), 0.5 * (self.low + self.high)
        left = _Pieces(np.stack([b0, c0, d0, middle], axis=1), self.low, at)
        return left.with_(_Pieces(np.stack([middle, d1, c2, b3], axis=1), at, self.high))


def certify(path: JointPath, collision: CollisionModel, checks: int = 20_000) -> Certificate:
    """Try to prove that `path` keeps the rules of the motion that `collision` has begun, everywhere between its ends.

    Args:
        path: Smooth path.
        collision: Carries the rules; see `CollisionModel.keeps_away`.
        checks: Budget; a path that needs more is in doubt.
    """
    as_record(path, JointPath, "path")
    as_record(collision, CollisionModel, "collision")
    checks = as_whole(checks, "checks", least=0, most=LARGEST_COUNT)
    pieces = _Pieces(*path.bezier())
    reaches, first = collision.reaches, collision.checks
    for level in LEVELS:
        spreads = _spreads(pieces, reaches)
        while (spreads > level).any():
            wide = spreads > level
            if len(pieces) > checks:
                return Certificate(float(pieces.low[0]), collision.checks - first)
            pieces = pieces[~wide].with_(pieces[wide].halves())
            spreads = _spreads(pieces, reaches)
        if collision.checks - first + len(pieces) > checks:
            return Certificate(float(pieces.low[0]), collision.checks - first)
        free = np.array([collision.keeps_away(q, level) for q in pieces.middles()], dtype=bool)
        pieces = pieces[~free]
        if not len(pieces):
            return Certificate(None, collision.checks - first)
    return Certificate(float(pieces.low.min()), collision.checks - first)


def _spreads(pieces: _Pieces, reaches: FloatArray) -> FloatArray:
    """Return D of equation (1) for every piece (m,), [m]."""
    return np.abs(pieces.control - pieces.middles()[:, None]).max(axis=1) @ reaches
