"""Noise added to observations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Protocol, runtime_checkable

import numpy as np

from rlbench_pin.errors import InvalidValue
from rlbench_pin.values import NOT_NEGATIVE, Rule, Settings, as_interval


@runtime_checkable
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


def as_noise(value: object, what: str) -> NoiseModel:
    """Return `value`, or raise InvalidValue when it is no noise model."""
    if isinstance(value, type) or not isinstance(value, NoiseModel):
        hint = "`GaussianNoise(0.01)` is one, `Identity()` is none at all."
        raise InvalidValue(what, value, "has to be a noise model, an object with `apply(value, rng)`", hint)
    return value


def _as_clip(value: object, what: str) -> tuple[float, float] | None:
    return None if value is None else as_interval(value, what, finite=False)


class GaussianNoise(Settings):
    """Additive normal noise.

    Args:
        variance: Standard deviation, in the unit of the value; the name is the one existing code uses.
        min_max_clip: Bounds that the noisy value is clipped to, the lower first.

    Raises:
        InvalidValue: The deviation is NaN, infinite or negative, or the bounds are exchanged.
    """

    rules: ClassVar[Mapping[str, Rule]] = {"variance": NOT_NEGATIVE, "min_max_clip": _as_clip}
    variance: float
    min_max_clip: tuple[float, float] | None

    def __init__(self, variance: float, min_max_clip: tuple[float, float] | None = None) -> None:
        self.variance, self.min_max_clip = variance, min_max_clip

    def apply(self, value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return a noisy copy of `value`, of its dtype."""
        value = np.asarray(value)
        noisy = value + rng.normal(0.0, self.variance, value.shape)
        return (noisy if self.min_max_clip is None else np.clip(noisy, *self.min_max_clip)).astype(value.dtype)
