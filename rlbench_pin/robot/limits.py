"""Bounds of a joint vector: position, velocity, acceleration, effort."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.spatial import FloatArray


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of n joints, read-only arrays of shape (n,); velocity, acceleration and effort are symmetric."""

    lower: FloatArray
    """Smallest position [rad] or [m]."""
    upper: FloatArray
    """Largest position [rad] or [m]."""
    velocity: FloatArray
    """Largest speed [rad/s] or [m/s]."""
    acceleration: FloatArray
    """Largest acceleration [rad/s^2] or [m/s^2]."""
    effort: FloatArray
    """Largest torque [N m] or force [N]."""

    def __post_init__(self) -> None:
        """Copy every field into a read-only float array of one shape."""
        size = len(self.lower)
        for name in ("lower", "upper", "velocity", "acceleration", "effort"):
            array = np.array(getattr(self, name), dtype=float)
            if array.shape != (size,):
                raise ValueError(f"limit '{name}' has shape {array.shape}, not ({size},)")
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def capped(self, velocity: float, acceleration: float) -> JointLimits:
        """Return these limits with no joint faster than `velocity` [rad/s] or accelerating beyond `acceleration` [rad/s^2]."""
        return JointLimits(
            self.lower, self.upper, np.minimum(self.velocity, velocity), np.minimum(self.acceleration, acceleration), self.effort
        )

    def contains(self, q: FloatArray, tolerance: float = 0.0) -> bool:
        """Say whether a configuration (n,) lies within the position limits."""
        return bool(np.all(q >= self.lower - tolerance) and np.all(q <= self.upper + tolerance))

    def margin(self, q: FloatArray) -> float:
        """Return the distance of the joint nearest to one of its position limits."""
        return float(min(np.min(q - self.lower), np.min(self.upper - q)))
