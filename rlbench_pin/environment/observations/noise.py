"""Noise added to observations."""

from __future__ import annotations

from typing import Protocol

import numpy as np


class NoiseModel(Protocol):
    """Changes a measured array; must not modify its argument."""

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return `value` with noise, drawing only from `rng`."""
        ...


class Identity:
    """No noise."""

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return `value` itself."""
        return value


class GaussianNoise:
    """Additive normal noise.

    Args:
        variance: Standard deviation, in the unit of the value; the name is the one existing code uses.
        min_max_clip: Bounds that the noisy value is clipped to.
    """

    def __init__(self, variance: float, min_max_clip: tuple[float, float] | None = None) -> None:
        self.variance, self.min_max_clip = variance, min_max_clip

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return a noisy copy of `value`, of its dtype."""
        value = np.asarray(value)
        noisy = value + rng.normal(0.0, self.variance, value.shape)
        return (noisy if self.min_max_clip is None else np.clip(noisy, *self.min_max_clip)).astype(value.dtype)
