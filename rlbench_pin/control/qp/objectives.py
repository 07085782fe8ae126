"""Objectives of a Cartesian controller for one tick: translation and rotation of the tip, and posture of the arm.

The tip moves along the straight line to its goal, and rotates about one axis, as fast as possible so that it can stop there. With
the error e (position [m], or rotation vector [rad]), speeds are limited to

    s = min(v_max, A dt g(|e| / (A dt^2)))

where g (see `constraints`) is the largest speed per tick from which braking at A stops within |e|. Both parts are scaled
by the smaller of the two factors, so the path stays straight as long as joint limits allow the speed. Near the goal g is
the identity and one tick covers all of e.

The posture objective moves the null space towards a configuration q_p. In

    (w - w_0 g) ||d||^2 + w_0 g ||d - (q_p - q)||^2,       g = gain dt,

the null space moves by d = g (q_p - q) if w = w_0, for any w_0 > 0. Near singularities w rises above w_0: the sum
adds damping, and the posture term, whose weight is constant, cannot keep the tip from its goal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from eigenpy import HouseholderQR

from rlbench_pin.control.qp.constraints import largest_step, stopping_room
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import NOT_NEGATIVE, POSITIVE, check_settings, ruled

SMALL_STEP = 0.01
"""Step of the tip [m] or [rad] below which damping near singularities decreases."""


@dataclass(frozen=True, kw_only=True)
class TipObjective:
    """Motion of the tip towards its goal."""

    linear_speed: float = 1.0
    """Largest speed [m/s]."""
    angular_speed: float = 3.0
    """Largest angular speed [rad/s]."""
    linear_acceleration: float = 2.0
    """Deceleration towards the goal [m/s^2]."""
    angular_acceleration: float = 6.0
    """Angular deceleration towards the goal [rad/s^2]."""
    position_weight: float = 1.0
    """Weight of 1 m of error."""
    rotation_weight: float = 0.3
    """Weight of 1 rad of error."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is not finite and > 0 (also a ValueError)."""
        check_settings(self, dict.fromkeys(vars(self), POSITIVE))


@dataclass(frozen=True, kw_only=True)
class PostureObjective:
    """Motion of the arm in the null space of the tip."""

    gain: float = 1.0
    """Fraction of the distance to the preferred configuration that is covered per second [1/s]."""
    weight: float = 1e-5
    """Damping far from singularities, relative to the weights of the tip."""
    singular_weight: float = 1e-2
    """Damping in a singular configuration, for steps that are not small."""
    singular_below: float = 0.01
    """Manipulability sqrt(det(J J^T)) below which the damping rises from `weight` to `singular_weight`."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, negative or zero (also a ValueError)."""
        check_settings(self, ruled((NOT_NEGATIVE, "gain singular_weight"), (POSITIVE, "weight singular_below")))

    def damping(self, manipulability: float, step: float) -> float:
        """Return w: `weight`, and more at low manipulability (Nakamura), in proportion to the step (Sugihara).

        Args:
            manipulability: sqrt(det(J J^T)).
            step: Distance or angle of the tip in this tick, [m] or [rad].
        """
        lack = max(0.0, 1.0 - manipulability / self.singular_below)
        return self.weight + self.singular_weight * lack * lack * min(1.0, step / SMALL_STEP)


class TipApproach:
    """Computes the placement of the tip after each tick of its motion to a goal."""

    def __init__(self, tip: TipObjective, dt: float) -> None:
        """Prepare for ticks of `dt` [s]."""
        self._linear = _Pace.of(tip.linear_speed * dt, tip.linear_acceleration * dt * dt)
        self._angular = _Pace.of(tip.angular_speed * dt, tip.angular_acceleration * dt * dt)

    def next(self, now: pin.SE3, goal: Sequence[float]) -> tuple[pin.SE3, float]:
        """Return T_world_tip one tick after `now` towards the pose `goal` (7,) with a unit quaternion, and the larger of
        distance [m] and angle [rad] of this step.

        Quaternions a, b of the same half of the sphere have the chord |b - a| = 2 sin(h / 2) if a rotation by 2 h is
        between them. A fraction s of this rotation ends at (sin((1 - s) h) a + sin(s h) b) / sin(h).
        """
        x, y, z, ax, ay, az, aw = pin.SE3ToXYZQUAT(now).tolist()
        to_x, to_y, to_z, bx, by, bz, bw = goal
        if ax * bx + ay * by + az * bz + aw * bw < 0.0:
            bx, by, bz, bw = -bx, -by, -bz, -bw
        way = math.hypot(to_x - x, to_y - y, to_z - z)
        half = 2.0 * math.asin(0.5 * math.hypot(bx - ax, by - ay, bz - az, bw - aw))
        share, share_of_turn = self._linear.share(way), self._angular.share(2.0 * half)
        if share_of_turn < share:
            share = share_of_turn
        step = share * max(way, 2.0 * half)
        if share >= 1.0:
            return pin.XYZQUATToSE3(goal), step
        if half > 0.0:
            a, b = math.sin((1.0 - share) * half) / math.sin(half), math.sin(share * half) / math.sin(half)
            bx, by, bz, bw = a * ax + b * bx, a * ay + b * by, a * az + b * bz, a * aw + b * bw
        pose = [x + share * (to_x - x), y + share * (to_y - y), z + share * (to_z - z), bx, by, bz, bw]
        return pin.XYZQUATToSE3(pose), step


@dataclass(frozen=True, slots=True)
class _Pace:
    """Fraction of an error that one tick may cover; all values in [m] or [rad]."""

    fastest: float
    """Largest step."""
    unit: float
    """A dt^2."""
    far: float
    """Error above which the largest step allows stopping in time."""

    @classmethod
    def of(cls, fastest: float, unit: float) -> _Pace:
        return cls(fastest, unit, unit * float(stopping_room(np.array([fastest / unit]))[0]))

    def share(self, error: float) -> float:
        """Return the fraction of `error` to cover in one tick."""
        if error >= self.far:
            return self.fastest / error
        if error <= self.unit:
            return 1.0
        return largest_step(error, self.unit) / error


def moved(placement: pin.SE3, shift: FloatArray, turn: FloatArray) -> tuple[pin.SE3, float]:
    """Return T_world_tip shifted by (3,) [m] and rotated by the rotation vector (3,) [rad], both along world axes, and the larger
    of distance and angle.
    """
    step = max(math.sqrt(shift @ shift), math.sqrt(turn @ turn))
    return pin.SE3(pin.exp3(turn) @ placement.rotation, placement.translation + shift), step


class Manipulability:
    """sqrt(det(J J^T)) of Jacobians (6, n), the product of their singular values: 0 when rank is lost.

    The point and the axes of the twist do not matter: such a change has determinant 1.
    With J^T = Q R, where Q has orthonormal columns and R is upper triangular, it is the product of the diagonal of R.
    """

    def __init__(self, size: int) -> None:
        """Prepare for arms of `size` >= 6 joints."""
        decomposition = HouseholderQR(size, 6)  # small matrices: Eigen takes half the time that LAPACK takes
        self._decompose, self._triangle = decomposition.compute, decomposition.matrixQR

    def __call__(self, jacobian: FloatArray) -> float:
        """Return the manipulability of a Jacobian (6, n)."""
        self._decompose(jacobian.T)
        return abs(math.prod(self._triangle().diagonal().tolist()))
