"""Trajectory following: as a sequence of joint commands, or with feedback.

Two back-ends turn the reference (q_d, v_d, a_d) and the measured state into a command:

* `VelocityFollowing`, for arms that take velocities: u = (q_d(t + dt) - q_d(t)) / dt + k (q_d(t) - q), clipped to the
  interval that keeps all joint limits (`constraints`). Without error it reproduces the reference tick by tick.
* `ComputedTorque`, for arms that take torques: tau = M (a_d + 2 omega (v_d - v) + omega^2 (q_d - q)) + h. It cancels the
  dynamics, and the error obeys e'' + 2 omega e' + omega^2 e = 0: critically damped, the same in all joints.

`TrajectoryTracker` returns the configurations without feedback. `TrajectoryFollower` returns one command per tick, and reports
the tracking error.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.control.checks import as_state, check_made_of
from rlbench_pin.control.qp.constraints import HeldQuantity, JointBounds
from rlbench_pin.errors import InvalidTarget, InvalidValue
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number, as_record

MAX_TICKS = 10_000_000


class TrajectoryTracker(Iterator[FloatArray]):
    """Iterates over the configurations of a trajectory at t = dt, 2 dt, ...; the last one is exactly its end.

    With `least_speed`, the fastest joint moves at least at this mean speed in the first and in the last tick, if the motion is
    long enough. The commands in between are at most dt apart.
    """

    def __init__(self, trajectory: Trajectory, dt: float, least_speed: float = 0.0) -> None:
        """Start before the first command, with one command per `dt` [s]; `least_speed` in [rad/s]."""
        as_record(trajectory, Trajectory, "trajectory")
        dt = as_number(dt, "the control tick dt [s]", above=0.0)
        least_speed = as_number(least_speed, "least_speed", least=0.0)
        if trajectory.duration > MAX_TICKS * dt:
            raise InvalidValue("the control tick dt [s]", dt, f"gives too many commands for {trajectory.duration:.4g} s")
        self.trajectory, self.dt = trajectory, dt
        self._times = _even_times(trajectory, dt) if least_speed <= 0.0 else _brisk_times(trajectory, dt, least_speed)
        self.ticks = len(self._times)
        """Total number of commands."""
        self._done = 0

    @property
    def done(self) -> bool:
        """Whether the last command was returned."""
        return self._done >= self.ticks

    @property
    def time(self) -> float:
        """Time of the last command, along the trajectory [s]."""
        return float(self._times[self._done - 1]) if self._done else 0.0

    def __len__(self) -> int:
        """Return the number of remaining commands."""
        return self.ticks - self._done

    def __next__(self) -> FloatArray:
        """Return the next command (n,), [rad]."""
        return self.next_state()[0]

    def next_state(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the next command with its velocity and acceleration, and advance."""
        if self.done:
            raise StopIteration
        self._done += 1
        if self.done:
            last = self.trajectory.q[-1]
            return last.copy(), np.zeros_like(last), np.zeros_like(last)
        return self.trajectory.sample(self.time)


def _even_times(trajectory: Trajectory, dt: float) -> FloatArray:
    ticks = max(1, int(np.ceil(trajectory.duration / dt - 1e-9)))
    return np.minimum(dt * np.arange(1, ticks + 1), trajectory.duration)


def _brisk_times(trajectory: Trajectory, dt: float, least_speed: float) -> FloatArray:
    """Return the times of the commands; the first and the last tick cover more of the trajectory than the others."""
    moved = np.abs(trajectory.q - trajectory.q[0]).max(axis=1), np.abs(trajectory.q - trajectory.q[-1]).max(axis=1)
    far = least_speed * dt
    leaves, stays = np.flatnonzero(moved[0] >= far), np.flatnonzero(moved[1] >= far)
    duration = trajectory.duration
    if not len(leaves) or not len(stays):
        return np.array([duration])
    first, last = max(float(trajectory.times[leaves[0]]), dt), min(float(trajectory.times[stays[-1]]), duration - dt)
    if first >= last:
        return np.array([0.5 * duration, duration]) if duration > 1.5 * dt else np.array([duration])
    count = int(np.ceil((last - first) / dt - 1e-9))
    return np.append(np.linspace(first, last, count + 1), duration)


class FollowingBackend(Protocol):
    """Computes a command from a part of a trajectory and the state."""

    dt: float

    def command(self, trajectory: Trajectory, t: float, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the command (n,) to hold from `t` to `t + dt` [s], in state `q` [rad], `v` [rad/s]."""
        ...


class VelocityFollowing:
    """Commands joint velocities [rad/s]."""

    def __init__(self, limits: JointLimits, dt: float = 0.05, gain: float = 5.0, hold: HeldQuantity = "velocity") -> None:
        """Set the control tick [s] and the fraction of the error to correct per second [1/s]."""
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
        """Set the control tick [s] and omega [rad/s]."""
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
    """Tracking error over all commands so far."""

    ticks: int
    """Number of control ticks so far."""
    largest: float
    """Largest error of any joint [rad]."""
    rms: float
    """Root mean square error over ticks and joints [rad]."""
    last: float
    """Largest error of any joint at the last command [rad]."""


class TrajectoryFollower:
    """Follows one trajectory from t = 0; call `command` once per tick."""

    def __init__(self, trajectory: Trajectory, backend: FollowingBackend) -> None:
        """Start at the beginning of the trajectory."""
        self.trajectory, self.backend = as_record(trajectory, Trajectory, "trajectory"), backend
        if not callable(getattr(backend, "command", None)):
            raise InvalidTarget(
                "backend",
                backend,
                "has to be a back-end with a method `command`",
                "For example `VelocityFollowing(model.limits)`.",
            )
        self._ticks, self._squares, self._largest, self._last = 0, 0.0, 0.0, 0.0

    @property
    def time(self) -> float:
        """Time of the next command [s]."""
        return self._ticks * self.backend.dt

    @property
    def done(self) -> bool:
        """Whether the trajectory has ended; further commands hold its last configuration."""
        return self.time >= self.trajectory.duration - 1e-9

    def command(self, q: ArrayLike, v: ArrayLike) -> FloatArray:
        """Return the command (n,) of the next tick, and record the tracking error.

        Args:
            q: Measured configuration (n,), [rad].
            v: Measured joint velocity (n,), [rad/s].

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
