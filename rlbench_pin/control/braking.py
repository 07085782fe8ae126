"""Stopping in time: checks of the motion of one command and the hardest braking after it, against collisions and torque limits.

A command is safe if the whole path to standstill keeps the minimum distances (floors) of all pairs: the tick of the command,
then ticks that change the velocity of each joint by at most a dt towards zero. After a safe command, braking is safe, because
it is the remainder of the checked path. So a safe command always exists in a stationary world: brake.

Checking the path needs few distances. Bounds on motion (`robot.distances`) clear most pairs at once. The others are
measured at the end of the path. Since a distance changes by no more than the motion L between two configurations,

    d(s) >= (d_start + d_end - L) / 2        between them,

an interval that does not clear a pair is divided, first between ticks, then within one, until it clears the pair, shows a
violation, or L is negligible.

A motor whose torque limit is exceeded lags behind its command, also during braking, so the checked path is no longer valid.
Near full stretch, the second joint of the Panda needs most of its torque against gravity, and fast changes of the other joints
load it as well. So the torques of the path are computed for each tick, tau = M(q) a + h(q, v) with the mean acceleration a of the
tick, by recursive Newton-Euler. They must stay within a fraction of the motor limits.
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
"""Usable fraction of the torque limits on the path to standstill: q, v and inertia change slightly within a tick."""


class MotorCheck:
    """Computes the torques of one arm with its payload on paths to standstill."""

    def __init__(self, model: RobotModel, bounds: JointBounds) -> None:
        """Copy the dynamics of the arm, so that a payload does not change the model."""
        self.bounds = bounds
        self._arm = pin.Model(model.arm)
        self._data = self._arm.createData()
        self._last, self._bare = model.size, model.arm.inertias[model.size].copy()
        self._most, self._steps = (RESERVE * bounds.limits.effort).tolist(), bounds.step.tolist()
        self._payload = pin.Inertia.Zero()

    def carry(self, payload: pin.Inertia) -> None:
        """Set the payload of the arm, in the frame of its last joint; the same object as before has no effect."""
        if payload is not self._payload:
            self._payload = payload
            self._arm.inertias[self._last] = loaded(self._bare, payload)

    def overloaded(self, q: FloatArray, v: FloatArray, command: FloatArray) -> bool:
        """Return whether a motor lacks torque for `command` from `q` [rad] at `v` [rad/s], or for braking after it."""
        arm, data, most = self._arm, self._data, self._most
        for tick in np.array(self._way(q, v, command)):
            if any(torque > limit or torque < -limit for torque, limit in zip(pin.rnea(arm, data, *tick).tolist(), most)):
                return True
        return False

    def _way(self, q: FloatArray, v: FloatArray, command: FloatArray) -> list[tuple[list[float], list[float], list[float]]]:
        """Return configuration, velocity before and mean acceleration of each tick, until the last joint stops.

        Plain numbers are faster than arrays for few ticks of few joints.
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
"""Motion below which a piece is not divided further [m]; its pairs can violate their floor by at most half of it."""
TOLERANCE = 1e-6
"""Distances below the floor by this much are tolerated [m]: rounding."""


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """Motion over a part of a tick; velocities change linearly from `start` to `end` [rad/s]."""

    q: FloatArray
    """Configuration at its start (n,) [rad]."""
    start: FloatArray
    """Velocity at its start (n,), [rad/s]."""
    end: FloatArray
    """Velocity at its end (n,), [rad/s]."""
    duration: float
    """[s]."""

    def turns(self) -> FloatArray:
        """Return the maximum travel of each joint [rad]."""
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
        """Velocity at the start of each tick, shape (ticks, n), [rad/s]."""
        if lagging:
            self.start = np.where(late, np.concatenate([v[None], self.end[:-1]]), self.end)
        half = 0.5 * bounds.dt
        self.q = np.concatenate([q[None], q + (half * (self.start + self.end)).cumsum(axis=0)])
        """Configurations between ticks, shape (ticks + 1, n), [rad]."""
        self.turns = np.zeros_like(self.q)
        """Maximum travel of each joint so far, between ticks, shape (ticks + 1, n), [rad]."""
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
    """Yield the possible paths of `command` and the braking after it, from `q` [rad] at velocity `v` [rad/s].

    There is one path, or two with `hold="any"`: in the first all joints reach velocities at once, in the second the first
    `loaded_joints`, which carry the arm, reach them only at the end of a tick.
    """
    yield Way(bounds, q, v, command, np.full(len(command), bounds.hold == "acceleration"))
    if bounds.hold == "any":
        late = np.arange(len(command)) < loaded_joints
        yield Way(bounds, q, np.where(np.abs(command) > np.abs(v), command, v), command, late)


@dataclass(frozen=True, eq=False, slots=True)
class Pairs:
    """Pairs of bodies under examination, with their gradients and floors."""

    which: IndexArray
    """Indices of the pairs, shape (pairs,)."""
    levers: FloatArray
    """Shape (pairs, n), [m/rad]."""
    floors: FloatArray
    """Minimum distances, shape (pairs,), [m]."""

    def __getitem__(self, keep: BoolArray) -> Pairs:
        """Return the pairs where `keep` (pairs,) is true."""
        return Pairs(self.which[keep], self.levers[keep], self.floors[keep])


class BrakingCheck:
    """Checks whether there is a safe path to standstill after a command."""

    def __init__(self, distances: DistanceModel, bounds: JointBounds) -> None:
        """Use a distance model at the configuration of the arm, and the limits of braking."""
        self.distances, self.bounds = distances, bounds

    def unsafe(self, q: FloatArray, v: FloatArray, command: FloatArray, floors: FloatArray) -> IndexArray:
        """Return pairs that come nearer than `floors` (pairs,) [m] on the path; empty if the command is safe.

        The distance model must be at `q`. The result may omit pairs when the returned ones suffice to reject the command.
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
        """Return the distances of pairs with the arm at `q`, and the pairs below their floor."""
        self.distances.visit(q)
        found = self.distances.probe(pairs.which)
        return found, pairs.which[found < pairs.floors - TOLERANCE]

    def _between(
        self, way: Way, first: int, last: int, pairs: Pairs, moved: FloatArray, now: FloatArray, after: FloatArray
    ) -> IndexArray:
        """Return pairs that violate their floor between the starts of two ticks, where their distances are `now` and `after`.

        `moved` is the maximum motion of each pair so far, between ticks, shape (pairs, ticks + 1), [m].
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
        """Return pairs that violate their floor inside a piece, with the distances `now` and `after` at its ends."""
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
