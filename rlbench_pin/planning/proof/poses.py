"""The shapes of a world with the arm in many configurations, and how far they move around each."""

from __future__ import annotations

import numpy as np

from rlbench_pin.planning.proof.chain import skew
from rlbench_pin.planning.proof.pieces import Pieces
from rlbench_pin.planning.proof.shapes import IndexArray, Shapes
from rlbench_pin.spatial import FloatArray


class Poses:
    """Placed shapes.

    No joint turns by more than T_j, so that no point of a shape moves farther than

        D = sum_j min(l_j + D0 / (1 - sum_i T_i), r_j) T_j,  D0 = sum_i l_i T_i               (1)

    with levers l_j, the largest distance of its ball from the joint's axis, and reaches r_j (`robot.motion_bounds`).

    Args:
        shapes: What is placed.
        pieces: In the middle of each of these, m of them.
    """

    def __init__(self, shapes: Shapes, pieces: Pieces) -> None:
        self.shapes, self.pieces, q = shapes, pieces, pieces.middles
        self.arm = shapes.chain.place(q)
        moving, carrier = shapes.moving, shapes.depth[shapes.moving] - 1
        rotations = self.arm.rotations.take(carrier, axis=1)
        centers = (rotations @ shapes.center[moving, :, None])[..., 0] + self.arm.origins.take(carrier, axis=1)
        halves = (np.abs(rotations @ shapes.rotation[moving]) @ shapes.half[moving, :, None])[..., 0]
        self._row = np.zeros(len(shapes.depth), dtype=np.intp)
        self._row[moving] = np.arange(len(moving))
        self._centers = np.repeat(shapes.center.T[:, None], len(q), axis=1)  # (3, m, k): numpy is fast along the last axis
        self._halves = np.repeat(shapes.upright.T[:, None], len(q), axis=1)
        self._centers[:, :, moving] = centers.transpose(2, 0, 1)
        self._halves[:, :, moving] = halves.transpose(2, 0, 1)
        self._measure_levers(centers)

    def _measure_levers(self, centers: FloatArray) -> None:
        """Compute equation (1) for moving shapes with ball centres (m, s, 3)."""
        arm, shapes, turns = self.arm, self.shapes, self.pieces.turns
        count, size = turns.shape
        speeds = skew(arm.angular).reshape(count, 3 * size, 3) @ centers.swapaxes(1, 2)
        speeds = speeds.reshape(count, size, 3, -1) + arm.linear[..., None]  # (m, n, 3, s)
        speeds *= speeds
        levers = np.sqrt(speeds[:, :, 0] + speeds[:, :, 1] + speeds[:, :, 2]).swapaxes(1, 2)
        levers = (levers + shapes.radius[:, None]) * (np.arange(size) < shapes.depth[shapes.moving, None])
        left = np.maximum(1.0 - turns.sum(axis=1), 1e-9)
        growth = (levers @ turns[:, :, None]) / left[:, None, None]
        self.levers = np.minimum(levers + growth, shapes.reaches)
        """How far a moving shape gets from the axis of each joint on the piece at most, shape (m, s, n), [m]."""
        self._parts = np.zeros((*levers.shape[:2], levers.shape[2] + 1))
        np.cumsum(self.levers * turns[:, None], axis=2, out=self._parts[:, :, 1:])

    def levers_of(self, piece: IndexArray, pair: IndexArray) -> FloatArray:
        """Return the levers of the farther shapes of pairs, shape (e, n), [m]."""
        return self.levers[piece, self._row[self.shapes.far[pair]]]

    def moves(self, piece: IndexArray, pair: IndexArray) -> FloatArray:
        """Return how far the two shapes of pairs move against each other at most, shape (e,), [m]."""
        row = self._row[self.shapes.far[pair]]
        return self._parts[piece, row, -1] - self._parts[piece, row, self.shapes.depth[self.shapes.near[pair]]]

    def close(self, pairs: IndexArray, floors: FloatArray) -> tuple[IndexArray, IndexArray]:
        """Return piece and pair (e,) of those that boxes along the world's axes do not show to stay apart.

        Args:
            pairs: Indices of the pairs that count.
            floors: What distance each pair has to keep, shape (all pairs,), [m].
        """
        shapes = self.shapes
        far, near = shapes.far[pairs], shapes.near[pairs]
        gap = np.abs(self._centers.take(far, axis=2) - self._centers.take(near, axis=2))  # (3, m, pairs)
        gap -= self._halves.take(far, axis=2)
        gap -= self._halves.take(near, axis=2)
        np.maximum(gap, 0.0, out=gap)
        gap *= gap
        row, depth = self._row[far], shapes.depth[near]
        needed = self._parts[:, row, -1] - self._parts[:, row, depth] + floors[pairs]
        piece, at = np.nonzero((gap[0] + gap[1] + gap[2] < needed * needed) | (needed < 0.0))
        return piece, pairs[at]

    def centers(self, piece: IndexArray, pair: IndexArray) -> FloatArray:
        """Return the centres of the farther shapes of pairs in the world, shape (e, 3), [m]."""
        return self._centers[:, piece, self.shapes.far[pair]].T

    def box(self, piece: IndexArray, pair: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Return how the boxes of the farther shapes of pairs are turned (e, 3, 3), and half their edges (e, 3), [m]."""
        far = self.shapes.far[pair]
        rotations = self.arm.rotations[piece, self.shapes.depth[far] - 1] @ self.shapes.rotation[far]
        return rotations, self.shapes.half[far]
