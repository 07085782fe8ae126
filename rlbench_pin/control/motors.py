"""Have the motors the torque for a motion and for the hardest braking after it?

A motor that is asked for more than its torque falls behind, also while it brakes, and what was planned for it does not hold.
Near full stretch the Panda's second joint needs most of its torque against gravity; fast changes of the other joints push on it
as well. So the torques of the way to standstill are computed tick by tick, tau = M(q) a + h(q, v) with the mean acceleration a of
the tick, by recursive Newton-Euler, and have to stay within a share of what the motors have.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rlbench_pin.control.qp.constraints import JointBounds
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
