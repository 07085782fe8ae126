"""Bounds of a joint vector: position, velocity, acceleration, effort."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array, as_number, as_vector


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
        """Copy every field into a read-only float array of one shape; raise InvalidValue where that cannot be."""
        size = as_array(self.lower, "JointLimits.lower").size
        for name in ("lower", "upper", "velocity", "acceleration", "effort"):
            array = as_array(getattr(self, name), f"JointLimits.{name}").copy()
            if array.shape != (size,) or np.isnan(array).any():
                raise InvalidValue(f"JointLimits.{name}", array, f"has to have shape ({size},), not {array.shape}, without NaN")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if np.any(self.lower > self.upper):
            raise InvalidValue("JointLimits.lower", self.lower, f"has to be below `upper`, which is {self.upper}")
        for name in ("velocity", "acceleration", "effort"):
            if np.any(getattr(self, name) < 0.0):
                raise InvalidValue(f"JointLimits.{name}", getattr(self, name), "has to be >= 0")

    def capped(self, velocity: float, acceleration: float) -> JointLimits:
        """Return these limits with no joint faster than `velocity` [rad/s] or accelerating beyond `acceleration` [rad/s^2].

        Raises:
            InvalidValue: One of them is not > 0 (also a ValueError).
        """
        for value, what in ((velocity, "velocity"), (acceleration, "acceleration")):
            as_number(value, what, above=0.0, finite=False)
        return JointLimits(
            self.lower, self.upper, np.minimum(self.velocity, velocity), np.minimum(self.acceleration, acceleration), self.effort
        )

    def contains(self, q: FloatArray, tolerance: float = 0.0) -> bool:
        """Say whether a configuration (n,) lies within the position limits."""
        q, tolerance = as_vector(q, len(self.lower), "configuration"), as_number(tolerance, "tolerance", finite=False)
        return bool(np.all(q >= self.lower - tolerance) and np.all(q <= self.upper + tolerance))

    def margin(self, q: FloatArray) -> float:
        """Return the distance of the joint nearest to one of its position limits."""
        q = as_vector(q, len(self.lower), "configuration")
        return float(min(np.min(q - self.lower), np.min(self.upper - q)))
