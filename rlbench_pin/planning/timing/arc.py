"""Limits along the path: of the joint-space speed |dq/dt| and of its change, whatever the joints are.

With the path q(s), u = d2s/dt2 and x = (ds/dt)^2, the speed along the arc is |q'| sqrt(x) and its change is

    d|dq/dt|/dt = (q' . ddq) / |q'| = |q'| u + (q' . q'') / |q'| x,

both linear in (u, x) once the speed is squared, as TOPPRA wants them (`constraint`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.errors import InvalidRequest
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_number

_TINY = 1e-12


@dataclass(frozen=True)
class ArcLimits:
    """Limits along the joint-space arc of a motion; those of the joints hold beside them."""

    velocity: float
    """Largest norm of the joint velocity [rad/s]."""
    acceleration: float
    """Largest change of that norm [rad/s^2]."""

    def __post_init__(self) -> None:
        """Raise InvalidRequest unless both are > 0."""
        for name in ("velocity", "acceleration"):
            as_number(getattr(self, name), f"ArcLimits.{name}", InvalidRequest, above=0.0, finite=False)

    def excess(self, tangents: FloatArray, v: FloatArray, before: FloatArray, after: FloatArray) -> float:
        """Return by which factor a motion must be slower to keep the limits; at most 1 when it keeps them.

        Args:
            tangents: Directions of the path at the samples, of any length, shape (m, n).
            v: Joint velocities, shape (m, n), [rad/s].
            before: Joint accelerations before each sample, shape (m, n), [rad/s^2].
            after: Those after it.
        """
        along = tangents / np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), _TINY)
        change = max(float(np.abs((a * along).sum(axis=1)).max()) for a in (before, after))
        return max(float(np.linalg.norm(v, axis=1).max()) / self.velocity, float(np.sqrt(change / self.acceleration)))

    def shortest(self, way: FloatArray) -> float:
        """Return how long a straight motion of `way` (n,) [rad] takes at least, with q = way (3 x^2 - 2 x^3), x = t / T [s]."""
        length = float(np.linalg.norm(way))
        return max(1.5 * length / self.velocity, float(np.sqrt(6.0 * length / self.acceleration)))
