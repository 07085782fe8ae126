"""Follow a trajectory with feedback: what to command now, and how well it goes.

Two back-ends turn the reference (q_d, v_d, a_d) and the measured state into a command:

* `VelocityFollowing`, for arms that take velocities: u = (q_d(t + dt) - q_d(t)) / dt + k (q_d(t) - q), clipped to the
  interval that keeps all joint limits (`constraints`). Without error it reproduces the reference tick by tick.
* `ComputedTorque`, for arms that take torques: tau = M (a_d + 2 omega (v_d - v) + omega^2 (q_d - q)) + h. It cancels the
  dynamics, and the error obeys e'' + 2 omega e' + omega^2 e = 0: critically damped, the same in all joints.

`TrajectoryFollower` walks along the trajectory, one command per tick, and reports the tracking error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.control.checks import as_state, check_made_of
from rlbench_pin.control.qp.constraints import HeldQuantity, JointBounds
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.limits import JointLimits
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number, as_record


class FollowingBackend(Protocol):
    """Turns a piece of a trajectory and the state into a command."""

    dt: float

    def command(self, trajectory: Trajectory, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the command (n,) to hold from `t` to `t + dt` [s], in state `q` [rad], `v` [rad/s]."""
        ...


class VelocityFollowing:
    """Commands joint velocities [rad/s]."""

    def __init__(self, limits: JointLimits, dt: float = 0.05, gain: float = 5.0, hold: HeldQuantity = "velocity") -> None:
        """Choose the tick [s] and the share of the error to remove per second [1/s]."""
        self.dt, self.gain = dt, as_number(gain, "gain", least=0.0)
        self.bounds = JointBounds(limits, dt, hold)

    def _state(self, trajectory: Trajectory, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        as_record(trajectory, Trajectory, "trajectory")
        return as_state(q, v, len(self.bounds.velocity))

    def command(self, trajectory: Trajectory, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the joint velocity (n,), [rad/s]."""
        q, v = self._state(trajectory, q, v)
        now, after = trajectory.sample(t), trajectory.sample(t + self.dt)
        feedforward = (after[0] - now[0]) / self.dt if self.bounds.hold == "velocity" else after[1]
        slowest, fastest = self.bounds.interval(q, v)
        return np.minimum(np.maximum(feedforward + self.gain * (now[0] - q), slowest), fastest)


class ComputedTorque:
    """Commands joint torques [N m]."""

    def __init__(self, model: RobotModel, dt: float = 1.0 / 240.0, frequency: float = 20.0) -> None:
        """Choose the tick [s] and omega [rad/s]."""
        check_made_of(model)
        self.model, self.dt = model, as_number(dt, "the control tick dt [s]", above=0.0)
        self.frequency = as_number(frequency, "frequency", least=0.0)

    def command(self, trajectory: Trajectory, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the joint torques (n,), [N m], within the effort limits."""
        as_record(trajectory, Trajectory, "trajectory")
        q, v = as_state(q, v, self.model.size)
        q_d, v_d, a_d = trajectory.sample(t)
        omega, effort = self.frequency, self.model.limits.effort
        a = a_d + 2.0 * omega * (v_d - v) + omega * omega * (q_d - q)
        return np.clip(self.model.inverse_dynamics(q, v, a), -effort, effort)


@dataclass(frozen=True)
class TrackingReport:
    """How far the arm was from its trajectory, over all commands so far."""

    ticks: int
    """Control ticks that were run."""
    largest: float
    """Largest error of any joint [rad]."""
    rms: float
    """Root mean square error over ticks and joints [rad]."""
    last: float
    """Largest error of any joint when last asked [rad]."""


class TrajectoryFollower:
    """Follows one trajectory from t = 0; ask for a command once per tick."""

    def __init__(self, trajectory: Trajectory, backend: FollowingBackend) -> None:
        """Start at the trajectory's begin."""
        self.trajectory, self.backend = as_record(trajectory, Trajectory, "trajectory"), backend
        if not callable(getattr(backend, "command", None)):
            raise InvalidTarget(
                "backend", backend, "has to turn states into commands", "For example `VelocityFollowing(model.limits)`."
            )
        self._ticks, self._squares, self._largest, self._last = 0, 0.0, 0.0, 0.0

    @property
    def time(self) -> float:
        """Time of the next command [s]."""
        return self._ticks * self.backend.dt

    @property
    def done(self) -> bool:
        """Whether the trajectory is over; further commands hold its end."""
        return self.time >= self.trajectory.duration - 1e-9

    def command(self, q: ArrayLike, v: ArrayLike) -> FloatArray:
        """Return the command (n,) of the next tick, and note the error.

        Args:
            q: Configuration now (n,), [rad].
            v: Joint velocity now (n,), [rad/s].

        Raises:
            InvalidTarget: NaN or a wrong shape.
        """
        q, v = as_state(q, v, self.trajectory.q.shape[1])
        error = self.trajectory.sample(self.time)[0] - q
        self._last = float(np.abs(error).max())
        self._largest = max(self._largest, self._last)
        self._squares += float(error @ error) / len(error)
        command = self.backend.command(self.trajectory, self.time, q, v)
        self._ticks += 1
        return command

    @property
    def report(self) -> TrackingReport:
        """The tracking error so far."""
        return TrackingReport(self._ticks, self._largest, float(np.sqrt(self._squares / max(1, self._ticks))), self._last)
