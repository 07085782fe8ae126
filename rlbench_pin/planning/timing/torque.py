"""Joint torques along a motion, with what the hand carries: tau = M(q) a + C(q, v) v + g(q), by Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import toppra
import toppra.constraint
from numpy.typing import NDArray

from rlbench_pin.robot.model import LARGEST, RobotModel, loaded
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number, as_record, as_vector

DENSE = 1e-3
"""Time between two evaluations of the torques of a finished trajectory [s]."""
_LOOK = 0.05
"""Time [s] and joint distance [rad] between the samples of the quick bound, at most."""
_GLANCE, _EASILY = 0.2, 0.88
"""The same of a first look, which is enough where torques stay below that share of the limits: on 100 motions the largest between
such samples was 0.5 % of a limit above the largest at them."""
_RESERVE = 0.97
_ROUNDS = 12


class TorqueLimits:
    """The dynamics of one arm with a payload, and the torques its joints may give."""

    def __init__(self, model: RobotModel, payload: pin.Inertia | None = None) -> None:
        """Copy the arm's dynamics, so that the payload stays here.

        Args:
            model: The arm.
            payload: What it carries, in the frame of its last joint; None for nothing.
        """
        as_record(model, RobotModel, "model")
        self._arm = pin.Model(model.arm)
        self._last, self._bare = model.size, model.arm.inertias[model.size].copy()
        self.limit = model.limits.effort
        self.carry(payload)

    def carry(self, payload: pin.Inertia | None) -> None:
        """Replace the payload."""
        payload = pin.Inertia.Zero() if payload is None else as_record(payload, pin.Inertia, "payload")
        self._arm.inertias[self._last] = loaded(self._bare, payload)
        self._data = self._arm.createData()

    def torques(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return the torques (n,) of one instant [N m].

        Raises:
            InvalidValue: NaN, a wrong shape, or no numbers (also a ValueError).
        """
        q, v, a = (as_vector(x, self._last, what, most=LARGEST) for x, what in ((q, "q"), (v, "v"), (a, "a")))
        return np.array(pin.rnea(self._arm, self._data, q, v, a))

    def constraint(self) -> toppra.constraint.Constraint:
        """Return the limits as TOPPRA wants them."""
        bound = _RESERVE * np.stack([-self.limit, self.limit], axis=1)
        scheme = toppra.constraint.DiscretizationType.Interpolation
        friction = np.zeros(len(self.limit))
        return toppra.constraint.JointTorqueConstraint(self.torques, bound, friction, discretization_scheme=scheme)

    def surely_kept(self, trajectory: Trajectory, acceleration: FloatArray) -> bool:
        """Say whether no acceleration within +-`acceleration` (n,) could break a limit on the way; quick, and cautious."""
        as_record(trajectory, Trajectory, "trajectory")
        acceleration = as_vector(acceleration, self._last, "acceleration")
        return any(
            self._within(trajectory, acceleration, look, share * self.limit)
            for look, share in ((_GLANCE, _EASILY), (_LOOK, _RESERVE))
        )

    def _within(self, trajectory: Trajectory, acceleration: FloatArray, look: float, limit: FloatArray) -> bool:
        """Say whether that holds of torques `limit` (n,) [N m] at samples that are about `look` [s] or [rad] apart."""
        which = _spaced(trajectory, look)
        rest, upper = np.empty((len(which), len(limit))), np.empty((len(which), len(limit), len(limit)))
        for k, (q, v) in enumerate(zip(trajectory.q[which], trajectory.v[which], strict=True)):
            rest[k] = pin.nonLinearEffects(self._arm, self._data, q, v)
            upper[k] = pin.crba(self._arm, self._data, q)
        upper = np.triu(np.abs(upper))
        inertia = upper + np.triu(upper, 1).swapaxes(1, 2)
        return not bool((np.abs(rest) + inertia @ acceleration > limit).any())

    def worst(self, trajectory: Trajectory, dt: float = DENSE) -> float:
        """Return the largest |tau| / limit, looking every `dt` [s] and at every sample."""
        duration = as_record(trajectory, Trajectory, "trajectory").duration
        as_number(dt, "dt [s]", least=duration * 1e-7, above=0.0)
        times = np.unique(np.concatenate([np.arange(0.0, trajectory.duration, dt), trajectory.times]))
        ratios = [np.abs(self.torques(*trajectory.sample(t))) / self.limit for t in times]
        return float(np.max(ratios))

    def slowed(self, trajectory: Trajectory) -> Trajectory:
        """Return the trajectory, uniformly slower where that is needed to keep the limits everywhere.

        Slowing down does not help against gravity: a payload beyond the arm's strength is carried as slowly as 1/10 of the speed.
        """
        for _ in range(_ROUNDS):
            ratio = self.worst(trajectory)
            if ratio <= 1.0:
                return trajectory
            trajectory = stretched(trajectory, min(1.25, 1.0 + max(0.002, 0.7 * (ratio - 1.0))))
        return trajectory


def _spaced(trajectory: Trajectory, look: float) -> NDArray[np.intp]:
    """Return samples of a trajectory that are about `look` apart in time or, if that is nearer, along the path."""
    steps = np.maximum(np.diff(trajectory.times), np.abs(np.diff(trajectory.q, axis=0)).max(axis=1)) / look
    return np.flatnonzero(np.diff(np.floor(np.concatenate([[-1.0, 0.0], np.cumsum(steps)]))))


def stretched(trajectory: Trajectory, factor: float) -> Trajectory:
    """Return the trajectory `factor` times slower."""
    return Trajectory(trajectory.times * factor, trajectory.q, trajectory.v / factor, trajectory.a / factor**2)
