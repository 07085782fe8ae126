"""A timed joint motion: t -> q, v, a."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.spatial import FloatArray


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joint motion sampled finely in time, evaluated between the samples by cubic Hermite interpolation.

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
        """Keep lists as arrays."""
        for name in ("times", "q", "v", "a"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return float(self.times[-1])

    def sample(self, t: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return q, v, a at time `t` [s]; before the start and after the end the joints rest."""
        if t < 0.0 or t > self.duration:
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
