"""A timed joint motion: t -> q, v, a."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array, as_finite, as_number, as_rows


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A sampled joint motion, with cubic Hermite interpolation between the samples.

    `times` has shape (m,), [s], starts at 0 and increases; `q`, `v`, `a` have shape (m, nq), [rad], [rad/s], [rad/s^2].
    """

    times: FloatArray
    """Shape (m,), [s]."""
    q: FloatArray
    """Positions (m, n), [rad]."""
    v: FloatArray
    """Velocities (m, n), [rad/s]."""
    a: FloatArray
    """Accelerations (m, n), [rad/s^2]."""

    def __post_init__(self) -> None:
        """Raise InvalidValue unless there are samples at increasing times and all fields are equally long (also a ValueError)."""
        times = as_array(self.times, "Trajectory.times")
        as_finite(times, "Trajectory.times")
        if times.ndim != 1 or not len(times) or times[0] != 0.0 or (np.diff(times) <= 0.0).any():
            raise InvalidValue("Trajectory.times", self.times, "has to have shape (m,), start at 0 and increase")
        q = as_array(self.q, "Trajectory.q")
        for name in ("q", "v", "a"):
            rows = as_rows(getattr(self, name), q.shape[-1] if q.ndim else 1, f"Trajectory.{name}")
            if len(rows) != len(times):
                raise InvalidValue(f"Trajectory.{name}", rows, f"has to have {len(times)} rows, one for each of `times`")
            object.__setattr__(self, name, rows)
        object.__setattr__(self, "times", times)

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.times[-1])

    def sample(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return q, v, a at time `t` [s]; the joints are at rest before the start and after the end."""
        t = as_number(t, "the time t [s]", finite=False)
        if t < 0.0 or t > self.duration or len(self.times) == 1:
            q = self.q[0] if t < 0.0 else self.q[-1]
            return q.copy(), np.zeros_like(q), np.zeros_like(q)
        i = min(int(np.searchsorted(self.times, t, side="right")) - 1, len(self.times) - 2)
        h = self.times[i + 1] - self.times[i]
        s = (t - self.times[i]) / h
        q0, q1, m0, m1 = self.q[i], self.q[i + 1], h * self.v[i], h * self.v[i + 1]
        s2, s3 = s * s, s * s * s
        q = (2 * s3 - 3 * s2 + 1) * q0 + (s3 - 2 * s2 + s) * m0 + (3 * s2 - 2 * s3) * q1 + (s3 - s2) * m1
        v = ((6 * s2 - 6 * s) * (q0 - q1) + (3 * s2 - 4 * s + 1) * m0 + (3 * s2 - 2 * s) * m1) / h
        return q, v, (1 - s) * self.a[i] + s * self.a[i + 1]
