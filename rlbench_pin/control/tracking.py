"""Plays a trajectory as a sequence of joint commands, one per control tick."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rlbench_pin.errors import InvalidValue
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number, as_record

MOST_TICKS = 10_000_000


class TrajectoryTracker(Iterator[FloatArray]):
    """Iterates over the configurations of a trajectory at t = dt, 2 dt, ...; the last one is exactly its end.

    With `least_speed` the first and the last command are so far from the ends that the fastest joint moves at least so fast on
    average in the first and in the last tick, where a motion is long enough; those in between are at most dt apart.
    """

    def __init__(self, trajectory: Trajectory, dt: float, least_speed: float = 0.0) -> None:
        """Start before the first command; a command per `dt` [s]; `least_speed` in [rad/s]."""
        as_record(trajectory, Trajectory, "trajectory")
        dt = as_number(dt, "the control tick dt [s]", above=0.0)
        least_speed = as_number(least_speed, "least_speed", least=0.0)
        if trajectory.duration > MOST_TICKS * dt:
            raise InvalidValue("the control tick dt [s]", dt, f"makes too many commands of {trajectory.duration:.4g} s")
        self.trajectory, self.dt = trajectory, dt
        self._times = _even_times(trajectory, dt) if least_speed <= 0.0 else _brisk_times(trajectory, dt, least_speed)
        self.ticks = len(self._times)
        """Number of commands in all."""
        self._done = 0

    @property
    def done(self) -> bool:
        """Whether the last command was given."""
        return self._done >= self.ticks

    @property
    def time(self) -> float:
        """Time of the last command, along the trajectory [s]."""
        return float(self._times[self._done - 1]) if self._done else 0.0

    def __len__(self) -> int:
        """Return how many commands are left."""
        return self.ticks - self._done

    def __next__(self) -> FloatArray:
        """Return the next command (n,), [rad]."""
        return self.next_state()[0]

    def next_state(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the next command with its velocity and acceleration; it counts as given."""
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
    """Return the times of the commands, the first and the last tick being longer along the trajectory than the others."""
    moved = np.abs(trajectory.q - trajectory.q[0]).max(axis=1), np.abs(trajectory.q - trajectory.q[-1]).max(axis=1)
    far = least_speed * dt
    leaves, stays = np.flatnonzero(moved[0] >= far), np.flatnonzero(moved[1] >= far)
    duration = trajectory.duration
    if len(leaves) == 0:
        return np.array([duration])
    first, last = max(float(trajectory.times[leaves[0]]), dt), min(float(trajectory.times[stays[-1]]), duration - dt)
    if first >= last:
        return np.array([0.5 * duration, duration]) if duration > 1.5 * dt else np.array([duration])
    count = int(np.ceil((last - first) / dt - 1e-9))
    return np.append(np.linspace(first, last, count + 1), duration)
