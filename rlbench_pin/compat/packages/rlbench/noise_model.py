"""Noise models of observations, with numpy's global generator."""

from __future__ import annotations

import numpy as np


class NoiseModel:
    """Base class of noise models. Subclasses override `apply`."""

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return `val` with noise."""
        raise NotImplementedError(f"{type(self).__name__} has no `apply(val)`. Override it.")


class Identity(NoiseModel):
    """No noise."""

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return `val` itself."""
        return val


class GaussianNoise(NoiseModel):
    """Additive normal noise.

    Args:
        variance: Standard deviation, in the unit of the value; RLBench uses this name.
        min_max_clip: Bounds of the noisy value, which is clipped to them.
    """

    def __init__(self, variance: float, min_max_clip: tuple[float, float] | None = None) -> None:
        self._variance, self._min_max_clip = variance, min_max_clip

    def apply(self, val: np.ndarray) -> np.ndarray:
        """Return a noisy copy of `val` with the same dtype."""
        value = np.asarray(val)
        noisy = value + np.random.normal(0.0, self._variance, value.shape)
        return (noisy if self._min_max_clip is None else np.clip(noisy, *self._min_max_clip)).astype(value.dtype)
