"""Can the arm still stop in time? The motion of one command and the hardest braking after it, checked against everything.

A command is safe when all of the way to standstill keeps the floors of all pairs, that is, their minimum distances: the
command's own tick, then ticks that change each joint's velocity by at most a dt towards zero. A safe command leaves a
state from which braking is safe, because it is the rest of the way that was checked. So there always is a safe command,
as long as the world stands still: brake.

Checking the way takes few distances. Bounds on motion (`robot.distances`) clear most pairs at once. The others are
measured at the ends of the pieces of the way, and since a distance changes by no more than the motion L of a piece,

    d(s) >= (d_start + d_end - L) / 2        on it,

a piece that does not clear a pair is halved until it does, or shows a violation, or L is too small to matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.control.constraints import JointBounds
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.motion_bounds import IndexArray
from rlbench_pin.spatial import FloatArray

BoolArray = NDArray[np.bool_]
RESOLUTION = 2e-3
"""Motion [m] of a piece that is not halved any more; its pairs may be below their floor by half of it, and are so by far less."""
CARRIERS = 2
"""Joints at the base whose load can keep their motors from reaching a velocity at once; the others bear little."""
TOLERANCE = 1e-6
"""Distances below the floor by this much are forgiven [m]: rounding."""


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """Motion over one tick or part of it, velocities changing linearly from `start` to `end`, [rad/s]."""

    q: FloatArray
    """Configuration at its begin."""
    start: FloatArray
    end: FloatArray
    duration: float
    """[s]."""

    def at(self, share: float) -> FloatArray:
        """Return the configuration after `share` in [0, 1] of its duration."""
        return self.q + (share * self.duration) * (self.start + (0.5 * share) * (self.end - self.start))

    def turns(self) -> FloatArray:
        """Return how far each joint travels at most [rad]."""
        return (0.5 * self.duration) * (np.abs(self.start) + np.abs(self.end))

    def halves(self) -> tuple[Piece, Piece]:
        """Return the two halves."""
        middle, duration = 0.5 * (self.start + self.end), 0.5 * self.duration
        return Piece(self.q, self.start, middle, duration), Piece(self.at(0.5), middle, self.end, duration)


def ways_to_standstill(bounds: JointBounds, q: FloatArray, v: FloatArray, command: FloatArray) -> list[list[Piece]]:
    """Return the ways that `command` and the braking after it may take, from `q` [rad] moving at `v` [rad/s].

    One, or with `hold="any"` two: all joints reach velocities at once, and those that carry the arm only at the end of a tick.
    """
    late = np.full(len(command), bounds.hold == "acceleration")
    ways = [_way(bounds, q, v, command, late)]
    if bounds.hold == "any":
        late = np.arange(len(command)) < CARRIERS
        ways.append(_way(bounds, q, np.where(np.abs(command) > np.abs(v), command, v), command, late))
    return ways


def _way(bounds: JointBounds, q: FloatArray, v: FloatArray, command: FloatArray, late: BoolArray) -> list[Piece]:
    """Return the tick of `command` and the braking ticks after it; velocities of `late` joints (n,) change linearly in a tick."""
    pieces = [Piece(q, np.where(late, v, command), command, bounds.dt)]
    lagging = bool(late.any())
    while command.any():
        slower = bounds.braking(command)
        if not lagging and not slower.any():
            break
        pieces.append(Piece(pieces[-1].at(1.0), np.where(late, command, slower), slower, bounds.dt))
        command = slower
    return pieces


class BrakingCheck:
    """Tells whether a command leaves a safe way to standstill."""

    def __init__(self, distances: DistanceModel, bounds: JointBounds) -> None:
        """Use distances already placed at the arm's configuration, and the limits of braking."""
        self.distances, self.bounds = distances, bounds

    def unsafe(self, q: FloatArray, v: FloatArray, command: FloatArray, floors: FloatArray) -> IndexArray:
        """Return pairs that come nearer than `floors` (pairs,) [m] on the way; empty when the command is safe.

        The distances have to be placed at `q`. Only as many pairs are returned as it takes to refuse the command.
        """
        model = self.distances
        travel = self.bounds.travel(v, command)
        which = np.flatnonzero(model.bounds - model.motion.displacement(travel) < floors)
        if not len(which):
            return which
        now = model.measure(which)
        levers = model.motion.levers(travel)[model.motion.rows_of(which)]
        keep = now - levers @ travel < floors[which]
        if not keep.any():
            return which[:0]
        which, levers, now = which[keep], levers[keep], now[keep]
        for way in ways_to_standstill(self.bounds, q, v, command):
            bad = self._walk(way, which, levers, now, floors[which])
            if len(bad):
                return bad
        return which[:0]

    def _walk(
        self, pieces: list[Piece], which: IndexArray, levers: FloatArray, now: FloatArray, floors: FloatArray
    ) -> IndexArray:
        """Follow the pieces, dropping pairs that the rest of the way cannot bring near any more."""
        turns = np.array([piece.turns() for piece in pieces])
        ahead = turns[::-1].cumsum(axis=0)[::-1]  # from the begin of each piece to standstill
        for i, piece in enumerate(pieces):
            if not len(which):
                return which
            self.distances.visit(piece.at(1.0))
            after = self.distances.probe(which)
            bad = self._within(piece, which, levers, now, after, floors)
            if len(bad):
                return bad
            rest = levers @ ahead[i + 1] if i + 1 < len(pieces) else np.zeros(len(which))
            keep = after - rest < floors
            which, levers, now, floors = which[keep], levers[keep], after[keep], floors[keep]
        return which[:0]

    def _within(
        self, piece: Piece, which: IndexArray, levers: FloatArray, now: FloatArray, after: FloatArray, floors: FloatArray
    ) -> IndexArray:
        """Return pairs that break their floor inside a piece, whose distances at its ends are `now` and `after`."""
        broken = after < floors - TOLERANCE
        if broken.any():
            return which[broken]
        motion = levers @ piece.turns()
        open_ = (now + after - motion < 2.0 * floors) & (motion > RESOLUTION)
        if not open_.any():
            return which[:0]
        which, levers, now, after, floors = which[open_], levers[open_], now[open_], after[open_], floors[open_]
        first, second = piece.halves()
        self.distances.visit(second.q)
        middle = self.distances.probe(which)
        bad = self._within(first, which, levers, now, middle, floors)
        return bad if len(bad) else self._within(second, which, levers, middle, after, floors)
