"""Plays a trajectory as a sequence of joint commands, one per control tick."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray


class TrajectoryTracker(Iterator[FloatArray]):
    """Iterates over the configurations of a trajectory at t = dt, 2 dt, ...; the last one is exactly its end."""

    def __init__(self, trajectory: Trajectory, dt: float) -> None:
        """Start before the first command; a command per `dt` [s]."""
        if dt <= 0.0:
            raise ValueError(f"the control tick is > 0 s, not {dt}")
        self.trajectory, self.dt = trajectory, dt
        self.ticks = max(1, int(np.ceil(trajectory.duration / dt - 1e-9)))
        """Number of commands in all."""
        self._done = 0

    @property
    def done(self) -> bool:
        """Whether the last command was given."""
        return self._done >= self.ticks

    @property
    def time(self) -> float:
        """Time of the last command [s]."""
        return min(self._done * self.dt, self.trajectory.duration)

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
        return self.trajectory.sample(self._done * self.dt)
