"""Stopping in time: the motion of one command and the hardest braking after it, checked against everything and against torques.

A command is safe when all of the way to standstill keeps the floors of all pairs, that is, their minimum distances: the
command's own tick, then ticks that change each joint's velocity by at most a dt towards zero. A safe command leaves a
state from which braking is safe, because it is the rest of the way that was checked. So there always is a safe command,
as long as the world is stationary: brake.

Checking the way takes few distances. Bounds on motion (`robot.distances`) clear most pairs at once. The others are
measured at its end, and since a distance changes by no more than the motion L between two places,

    d(s) >= (d_start + d_end - L) / 2        between them,

what does not clear a pair is divided, first between ticks, then within one, until it does, or shows a violation, or L is
too small to matter.

A motor that is asked for more than its torque falls behind, also while it brakes, and what was planned for it does not hold.
Near full stretch the Panda's second joint needs most of its torque against gravity; fast changes of the other joints push on it
as well. So the torques of the way to standstill are computed tick by tick, tau = M(q) a + h(q, v) with the mean acceleration a of
the tick, by recursive Newton-Euler, and have to stay within a share of what the motors have.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.control.qp.constraints import JointBounds
from rlbench_pin.robot.distances import DistanceModel, IndexArray
from rlbench_pin.robot.model import RobotModel, loaded
from rlbench_pin.spatial import FloatArray

RESERVE = 0.95
"""Share of the torque limits that a way to standstill may take: q, v and inertia change a little within a tick."""


class MotorCheck:
    """The torques of one arm, with what it carries, on ways to standstill."""

    def __init__(self, model: RobotModel, bounds: JointBounds) -> None:
        """Copy the arm's dynamics, so that the payload stays here."""
        self.bounds = bounds
        self._arm = pin.Model(model.arm)
        self._data = self._arm.createData()
        self._last, self._bare = model.size, model.arm.inertias[model.size].copy()
        self._most, self._steps = (RESERVE * bounds.limits.effort).tolist(), bounds.step.tolist()
        self._payload = pin.Inertia.Zero()

    def carry(self, payload: pin.Inertia) -> None:
        """Take over what the arm carries, in the frame of its last joint; the same object as before changes nothing."""
        if payload is not self._payload:
            self._payload = payload
            self._arm.inertias[self._last] = loaded(self._bare, payload)

    def overloaded(self, q: FloatArray, v: FloatArray, command: FloatArray) -> bool:
        """Whether a motor lacks torque for `command` from `q` [rad] at `v` [rad/s], or for braking after it."""
        arm, data, most = self._arm, self._data, self._most
        for tick in np.array(self._way(q, v, command)):
            if any(torque > limit or torque < -limit for torque, limit in zip(pin.rnea(arm, data, *tick).tolist(), most)):
                return True
        return False

    def _way(self, q: FloatArray, v: FloatArray, command: FloatArray) -> list[tuple[list[float], list[float], list[float]]]:
        """Return configuration, velocity before and mean acceleration of each tick, down to that in which the last joint stops.

        Plain numbers: for few ticks of few joints they are faster than arrays.
        """
        dt, steps = self.bounds.dt, self._steps
        here, before, after = q.tolist(), v.tolist(), command.tolist()
        ticks = []
        while True:
            ticks.append((here, before, [(b - a) / dt for a, b in zip(before, after)]))
            if not any(after):
                return ticks
            here = [x + dt * speed for x, speed in zip(here, after)]
            before, after = after, [u - s if u > s else u + s if u < -s else 0.0 for u, s in zip(after, steps)]


BoolArray = NDArray[np.bool_]
RESOLUTION = 2e-3
"""Motion [m] of a piece that is not halved any more; its pairs may be below their floor by half of it, and are so by far less."""
TOLERANCE = 1e-6
"""Distances below the floor by this much are tolerated [m]: rounding."""


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """Motion over part of a tick, velocities changing linearly from `start` to `end`, [rad/s]."""

    q: FloatArray
    """Configuration at its begin."""
    start: FloatArray
    """Velocity at its begin (n,), [rad/s]."""
    end: FloatArray
    """Velocity at its end (n,), [rad/s]."""
    duration: float
    """[s]."""

    def turns(self) -> FloatArray:
        """Return how far each joint travels at most [rad]."""
        return (0.5 * self.duration) * (np.abs(self.start) + np.abs(self.end))

    def halves(self) -> tuple[Piece, Piece]:
        """Return the two halves."""
        middle, duration = 0.5 * (self.start + self.end), 0.5 * self.duration
        there = self.q + (0.5 * duration) * (self.start + middle)
        return Piece(self.q, self.start, middle, duration), Piece(there, middle, self.end, duration)


class Way:
    """The tick of a command and the braking ticks after it."""

    def __init__(self, bounds: JointBounds, q: FloatArray, v: FloatArray, command: FloatArray, late: BoolArray) -> None:
        """Follow `command` from `q` [rad] moving at `v` [rad/s]; velocities of `late` joints (n,) change linearly in a tick."""
        speed, lagging = np.abs(command), bool(late.any())
        braking = math.ceil((speed / bounds.step).max())  # ticks until all joints stand
        ticks = np.arange(1 + braking if lagging else max(1, braking))[:, None]
        self.end = np.sign(command) * np.maximum(speed - ticks * bounds.step, 0.0)
        """Velocity at the end of each tick, shape (ticks, n), [rad/s]."""
        self.start = self.end
        """And at its begin."""
        if lagging:
            self.start = np.where(late, np.concatenate([v[None], self.end[:-1]]), self.end)
        half = 0.5 * bounds.dt
        self.q = np.concatenate([q[None], q + (half * (self.start + self.end)).cumsum(axis=0)])
        """Configurations between ticks, shape (ticks + 1, n), [rad]."""
        self.turns = np.zeros_like(self.q)
        """How far each joint has travelled at most between ticks, shape (ticks + 1, n), [rad]."""
        np.cumsum(half * (np.abs(self.start) + np.abs(self.end)), axis=0, out=self.turns[1:])
        self.dt = bounds.dt

    def __len__(self) -> int:
        """Return the number of ticks."""
        return len(self.end)

    def tick(self, i: int) -> Piece:
        """Return the motion of one tick."""
        return Piece(self.q[i], self.start[i], self.end[i], self.dt)


def paths_to_standstill(
    bounds: JointBounds, q: FloatArray, v: FloatArray, command: FloatArray, loaded_joints: int
) -> Iterator[Way]:
    """Yield the ways that `command` and the braking after it may take, from `q` [rad] moving at `v` [rad/s].

    One, or with `hold="any"` two: all joints reach velocities at once, and the first `loaded_joints`, which carry the arm, only
    at the end of a tick.
    """
    yield Way(bounds, q, v, command, np.full(len(command), bounds.hold == "acceleration"))
    if bounds.hold == "any":
        late = np.arange(len(command)) < loaded_joints
        yield Way(bounds, q, np.where(np.abs(command) > np.abs(v), command, v), command, late)


@dataclass(frozen=True, eq=False, slots=True)
class Pairs:
    """Pairs of bodies under examination, and what is known of each."""

    which: IndexArray
    """Numbers of the pairs, shape (pairs,)."""
    levers: FloatArray
    """Shape (pairs, n), [m/rad]."""
    floors: FloatArray
    """Smallest distances allowed, shape (pairs,), [m]."""

    def __getitem__(self, keep: BoolArray) -> Pairs:
        """Return the pairs where `keep` (pairs,) is true."""
        return Pairs(self.which[keep], self.levers[keep], self.floors[keep])


class BrakingCheck:
    """Checks whether a command leaves a safe way to standstill."""

    def __init__(self, distances: DistanceModel, bounds: JointBounds) -> None:
        """Use distances already placed at the arm's configuration, and the limits of braking."""
        self.distances, self.bounds = distances, bounds

    def unsafe(self, q: FloatArray, v: FloatArray, command: FloatArray, floors: FloatArray) -> IndexArray:
        """Return pairs that come nearer than `floors` (pairs,) [m] on the way; empty when the command is safe.

        The distances have to be placed at `q`. Only as many pairs are returned as it takes to refuse the command.
        """
        model = self.distances
        travel = self.bounds.travel(v, command)
        which = (model.bounds - model.motion.displacement(travel) < floors).nonzero()[0]
        if not len(which):
            return which
        now = model.measure(which)
        levers = model.motion.levers(travel)[model.motion.rows_of(which)]
        keep = now - levers @ travel < floors[which]
        if not keep.any():
            return which[:0]
        pairs, now = Pairs(which, levers, floors[which])[keep], now[keep]
        for way in paths_to_standstill(self.bounds, q, v, command, model.model.description.loaded_joints):
            after, broken = self._measured(way.q[-1], pairs)
            if not len(broken):
                broken = self._between(way, 0, len(way), pairs, pairs.levers @ way.turns.T, now, after)
            if len(broken):
                return broken
        return which[:0]

    def _measured(self, q: FloatArray, pairs: Pairs) -> tuple[FloatArray, IndexArray]:
        """Return the distances of pairs with the arm at `q`, and which of them are below their floor."""
        self.distances.visit(q)
        found = self.distances.probe(pairs.which)
        return found, pairs.which[found < pairs.floors - TOLERANCE]

    def _between(
        self, way: Way, first: int, last: int, pairs: Pairs, moved: FloatArray, now: FloatArray, after: FloatArray
    ) -> IndexArray:
        """Return pairs that break their floor between the begins of two ticks, where their distances are `now` and `after`.

        `moved` is how far each pair has moved at most between ticks, shape (pairs, ticks + 1), [m].
        """
        motion = moved[:, last] - moved[:, first]
        keep = (now + after - motion < 2.0 * pairs.floors) & (motion > RESOLUTION)
        if not keep.any():
            return pairs.which[:0]
        pairs, moved, now, after = pairs[keep], moved[keep], now[keep], after[keep]
        if last == first + 1:
            return self._within(way.tick(first), pairs, now, after)
        middle = first + (last - first + 1) // 3  # the first ticks are the fast ones
        between, broken = self._measured(way.q[middle], pairs)
        if not len(broken):
            broken = self._between(way, first, middle, pairs, moved, now, between)
        return broken if len(broken) else self._between(way, middle, last, pairs, moved, between, after)

    def _within(self, piece: Piece, pairs: Pairs, now: FloatArray, after: FloatArray) -> IndexArray:
        """Return pairs that break their floor inside a piece, whose distances at its ends are `now` and `after`."""
        motion = pairs.levers @ piece.turns()
        keep = (now + after - motion < 2.0 * pairs.floors) & (motion > RESOLUTION)
        if not keep.any():
            return pairs.which[:0]
        pairs, now, after = pairs[keep], now[keep], after[keep]
        first, second = piece.halves()
        middle, broken = self._measured(second.q, pairs)
        if not len(broken):
            broken = self._within(first, pairs, now, middle)
        return broken if len(broken) else self._within(second, pairs, middle, after)
