"""Velocity bounds that keep joint position, velocity and acceleration limits at all times, not only in the next tick.

A joint at position q with velocity v takes its next velocity u, then brakes by at most a dt per tick until it stops.
With velocities held over a tick (`hold="velocity"`), stopping from u takes n = floor(u / (a dt)) more moving ticks and

    q + dt (u + (u - a dt) + (u - 2 a dt) + ...)  <=  upper                                  (1)

In the unit a dt of velocity and a dt^2 of position, the sum is f(u) = (n + 1) u - n (n + 1) / 2, which is continuous,
increasing and piecewise linear. With the room m = (upper - q) / (a dt^2) the largest allowed u is its inverse,

    g(m) = (m + n (n + 1) / 2) / (n + 1),    n = floor((sqrt(1 + 8 m) - 1) / 2)              (2)

With velocities that change linearly over the tick (`hold="acceleration"`), the trapezoidal sum of (1) telescopes to the same f
with the room reduced by dt v / 2. Motors of limited torque are in between. `hold="any"` takes the worst of both:
a first tick of dt max(u, (u + v) / 2) and trapezoids after it, with the room reduced by dt max(u, v) / 2. The lower limit
is symmetric. The next velocity is in

    [max(-v_max, -g_lower, v - a dt), min(v_max, g_upper, v + a dt)].                        (3)

From a state inside the limits that can still stop, braking at a dt satisfies (3) and leads to such a state again, so the
interval is never empty (Del Prete, "Joint position and velocity bounds in discrete-time under acceleration/torque
limits", RA-L 2018, has the continuous counterpart). From a state that cannot stop in time, or is already outside, the
acceleration limit takes precedence: the interval shrinks to the hardest braking, then to the hardest return.
"""

from __future__ import annotations

import math
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.control.checks import LARGEST_STATE, as_state, as_vector
from rlbench_pin.robot.model import JointLimits
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_choice, as_flag, as_number, as_record

HELD_QUANTITIES = ("velocity", "acceleration", "any")
HeldQuantity = Literal["velocity", "acceleration", "any"]
"""Quantity that motors keep constant over a control tick: they reach the next velocity at its start, at its end, or at any
time in it."""
SpeedT = TypeVar("SpeedT", float, FloatArray)


def largest_step(room: float, unit: float) -> float:
    """Return the largest displacement of one tick after which braking stops within `room`, equation (2) times `unit` = a dt^2.

    Room and displacement are in [m] or [rad]. With a negative room (beyond the limit), it is the full return to the limit.
    """
    if room <= unit:
        return room
    ticks = int(0.5 * math.sqrt(1.0 + 8.0 * room / unit) - 0.5)
    return (room + 0.5 * ticks * (ticks + 1) * unit) / (ticks + 1)


def stopping_room(speed: SpeedT) -> SpeedT:
    """Return f(speed), the inverse of `largest_step` in its units: the room to stop from `speed`, a number or an array."""
    ticks = speed // 1.0
    return (ticks + 1.0) * (speed - 0.5 * ticks)


class JointBounds:
    """The interval of next velocities of n joints, equation (3)."""

    def __init__(
        self, limits: JointLimits, dt: float, hold: HeldQuantity = "velocity", margin: float = 0.0, *, sudden: bool = False
    ) -> None:
        """Prepare the constants.

        Args:
            limits: Position, velocity and acceleration limits of n joints.
            dt: Control tick [s].
            hold: Quantity that stays constant over a tick.
            margin: Distance kept from the position limits [rad].
            sudden: Allow any next velocity from which the joints can stop in time, without a limit of its change.

        Raises:
            InvalidValue: The tick is not > 0, or the margin is negative or above half the range of a joint (also a ValueError).
        """
        dt = as_number(dt, "the control tick dt [s]", above=0.0)
        as_record(limits, JointLimits, "limits")
        margin = as_number(
            margin, "the margin of joint limits [rad]", least=0.0, most=0.5 * float((limits.upper - limits.lower).min())
        )
        as_choice(hold, "held quantity", HELD_QUANTITIES)
        as_flag(sudden, "sudden")
        self.limits, self.dt, self.hold = limits, dt, hold
        self.velocity = np.array(limits.velocity)
        self.step = limits.acceleration * dt
        """Largest change of velocity in one tick, shape (n,), [rad/s]."""
        self._change = dt * self.step
        self._steps = list(zip(self.step.tolist(), self._change.tolist(), strict=True))
        reach, change = dt * self.velocity, self._change
        stop = change * stopping_room(self.velocity / self.step)
        stop += 0.0 if hold == "velocity" else 0.5 * reach
        lower, upper = limits.lower + margin, limits.upper - margin
        leap = np.full_like(change, np.inf) if sudden else change
        constants = (reach, change, leap, lower, upper, lower + stop, upper - stop)
        self._joints = list(zip(*(x.tolist() for x in constants), strict=True))

    def displacements(self, q: ArrayLike, v: ArrayLike) -> tuple[list[float], list[float]]:
        """Return dt times `interval`: n lowest and n highest displacements of the next tick, [rad].

        Plain numbers and comparisons take a third of the time of arrays for n = 7.
        """
        dt = self.dt
        lowest, highest = [], []
        positions, speeds = (x.tolist() for x in as_state(q, v, len(self.velocity)))
        for x, speed, (reach, change, leap, lower, upper, free_above, free_below) in zip(positions, speeds, self._joints):
            drift = dt * speed
            bottom, top = drift - leap, drift + leap
            least, most = -reach, reach
            if x < free_above:
                least = min(max(-reach, -self._step(x - lower, -drift, change)), reach)
            if x > free_below:
                most = max(min(reach, self._step(upper - x, drift, change)), -reach)
            lowest.append(bottom if least <= bottom else least if least < top else top)
            highest.append(top if most >= top else most if most > bottom else bottom)
        return lowest, highest

    def _step(self, room: float, drift: float, change: float) -> float:
        """Return the largest displacement of the next tick towards a limit `room` away, with dt v = `drift` towards it."""
        if self.hold == "velocity":
            return largest_step(room, change)
        if self.hold == "acceleration":
            return largest_step(room - 0.5 * drift, change)
        step = largest_step(room - 0.5 * max(drift, 0.0), change)
        return step if step <= max(drift, 0.0) else max(drift, largest_step(room - 0.5 * step, change))

    def interval(self, q: ArrayLike, v: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest next velocity, each (n,), [rad/s], of joints at `q` [rad] moving at `v` [rad/s]."""
        lowest, highest = np.array(self.displacements(q, v)) / self.dt
        return lowest, highest

    def braking(self, v: FloatArray) -> FloatArray:
        """Return the velocity (n,) after braking for one tick as hard as allowed."""
        v = as_vector(v, len(self.velocity), "joint velocity")
        return np.sign(v) * np.maximum(np.abs(v) - self.step, 0.0)

    def travel(self, v: FloatArray, command: FloatArray) -> FloatArray:
        """Return the maximum travel of each joint (n,) in the tick of `command` and the braking after it, [rad].

        It is dt (a dt) f(|command|) by (1). With `hold="acceleration"` the joint starts from `v`, which adds dt |v| / 2; with
        `hold="any"` half of the faster velocity is added.
        """
        return np.array(self.travels(v, command))

    def travels(self, v: FloatArray, command: FloatArray) -> list[float]:
        """Return `travel` as plain numbers."""
        v, command = (as_vector(x, len(self.velocity), "joint velocity", LARGEST_STATE) for x in (v, command))
        half, hold, ways = 0.5 * self.dt, self.hold, []
        for before, after, (step, change) in zip(v.tolist(), command.tolist(), self._steps):
            speed, before = abs(after), abs(before)
            way = change * stopping_room(speed / step)
            ways.append(way if hold == "velocity" else way + half * (before if hold == "acceleration" else max(before, speed)))
        return ways
