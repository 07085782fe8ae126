"""Proof that a motion is free between the checked configurations too (after Schwarzer, Saha, Latombe 2005).

A path is a sequence of Bezier pieces. No configuration of a piece is farther from its middle, joint by joint, than one of its
control points, which bounds how far each shape moves against each other one. A pair of shapes is settled for a whole piece by the
first of two bounds that is large enough:

1. the gap between their boxes along the world's axes in the middle of the piece, less how far they can move (`poses`), for all
   pieces in one go;
2. their distance there, by Coal, less what of their motion closes it (`planes`).

Pieces with pairs that are left are cut, and only these are looked at again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from rlbench_pin.planning.path import JointPath
from rlbench_pin.planning.proof.pieces import Pieces
from rlbench_pin.planning.proof.planes import advances
from rlbench_pin.planning.proof.poses import Poses
from rlbench_pin.planning.proof.shapes import ArmShapes, IndexArray, Shapes
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import LARGEST_COUNT, as_record, as_whole

WIDEST = 0.08
"""How far anything can move to either side of the middle of a first piece, at most [m]."""
LEAST = 3e-4
"""Pairs that close in by less than this, and still are not settled, are in doubt [m]."""
_PARTS, _MOST_PARTS = 2.0, 16
SURE = 1e-5
"""What distances have to be larger than asked for, because Coal's are not exact [m]."""


@dataclass(frozen=True)
class Certificate:
    """What was proven of a path."""

    doubt: float | None
    """Where on the path (0..1) nothing could be proven; None when all of it is free."""
    checks: int
    """Configurations in which distances were measured."""


class Prover:
    """Proves paths of one motion.

    Args:
        arm: The arm's own shapes.
        collision: Has begun the motion, and carries its rules.
    """

    def __init__(self, arm: ArmShapes, collision: CollisionModel) -> None:
        self._arm, self._collision = arm, collision

    @cached_property
    def _shapes(self) -> Shapes:
        return Shapes(self._arm, self._collision)

    def prove(self, path: JointPath, checks: int) -> Certificate:
        """Try to prove that `path` stays free of forbidden contacts, everywhere between its ends.

        Args:
            path: Smooth path.
            checks: Budget of configurations in which distances are measured.
        """
        counts, floors = self._collision.least_distances()
        floors, pieces, spent = floors + SURE, self._begin(path), 0
        poses = Poses(self._shapes, pieces)
        piece, pair = poses.close(np.flatnonzero(counts), floors)
        while len(pair):
            spent += len(pieces.low)
            distance, normal = self._measure(pieces.middles, piece, pair)
            room, moves = distance - floors[pair], poses.moves(piece, pair)
            left = np.flatnonzero(room < moves)
            piece, pair, room, moves, normal = piece[left], pair[left], room[left], moves[left], normal[left]
            closing = np.minimum(moves, advances(poses, piece, pair, normal))
            left = np.flatnonzero(room < closing)
            piece, pair, room, closing = piece[left], pair[left], room[left], closing[left]
            hopeless = (room <= 0.0) | (closing < LEAST)
            if hopeless.any() or (len(left) and spent > checks):
                return Certificate(float(pieces.low[piece[hopeless] if hopeless.any() else piece].min()), spent)
            if len(left):
                pieces, piece, pair = _cut(pieces, piece, pair, closing / room)
                poses = Poses(self._shapes, pieces)
        return Certificate(None, spent)

    def _begin(self, path: JointPath) -> Pieces:
        """Cut a path into pieces on which nothing moves much farther than `WIDEST` from its middle."""
        pieces, reaches = Pieces.of(path), self._shapes.reaches.max(axis=0)
        return pieces.cut(np.arange(len(pieces.low)), np.maximum(1, np.ceil(pieces.turns @ reaches / WIDEST)).astype(np.intp))

    def _measure(self, q: FloatArray, piece: IndexArray, pair: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Measure pairs in configurations q[piece], (m, n).

        Returns:
            Distances (e,), [m], negative where shapes overlap; normals (e, 3) from the farther shape to the other one.
        """
        distances, normals = [], []
        geometry, placed, last = self._collision.geometry.model, self._collision.geometry.data, -1
        for i, k in zip(piece.tolist(), pair.tolist(), strict=True):
            if i != last:
                self._arm.place(self._collision, q[i])
                last = i
            result = pin.computeDistance(geometry, placed, k)
            distances.append(result.min_distance)
            normals.append(result.normal)
        normal = np.array(normals)
        normal[self._shapes.second_farther[pair]] *= -1.0  # Coal's point from the first to the second shape
        return np.array(distances), normal


def _cut(pieces: Pieces, piece: IndexArray, pair: IndexArray, shares: FloatArray) -> tuple[Pieces, IndexArray, IndexArray]:
    """Cut the pieces that have pairs left, and give all parts these pairs, in the order of pieces.

    Args:
        pieces: All pieces.
        piece: Index of the piece (e,) of each pair that is left, in rising order.
        pair: Index of the pair (e,).
        shares: How much larger than the room there is, is what may be lost of it on the piece (e,).
    """
    chosen, first = np.unique(piece, return_index=True)
    counts = np.clip(np.ceil(_PARTS * np.maximum.reduceat(shares, first)), 2, _MOST_PARTS).astype(np.intp)
    parts = pieces.cut(chosen, counts)
    pairs = np.split(pair, first[1:])
    owner = np.repeat(np.arange(len(chosen)), counts)
    sizes = np.array([len(some) for some in pairs])
    return parts, np.repeat(np.arange(len(owner)), sizes[owner]), np.concatenate([pairs[k] for k in owner.tolist()])


def certify(path: JointPath, collision: CollisionModel, checks: int = 20_000) -> Certificate:
    """Try to prove that `path` keeps the rules of the motion that `collision` has begun, everywhere between its ends.

    Args:
        path: Smooth path.
        collision: Carries the rules: what counts, and how near things may come; see `CollisionModel.begin`.
        checks: Budget of configurations; a path that needs more is in doubt.
    """
    as_record(path, JointPath, "path")
    as_record(collision, CollisionModel, "collision")
    checks = as_whole(checks, "checks", least=0, most=LARGEST_COUNT)
    return Prover(ArmShapes(collision.model), collision).prove(path, checks)
