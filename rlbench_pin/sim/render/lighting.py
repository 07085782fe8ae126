"""Three directional lights: a key light that casts shadows, and two fills that do not."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.errors import CameraError, InvalidCamera
from rlbench_pin.values import as_number, as_vector

Vector = tuple[float, float, float]
SPECULAR = 0.05
"""Brightness of the highlight of the key light."""


@dataclass(frozen=True)
class Light:
    """A light that is infinitely far away."""

    direction: Vector
    """Points towards the light, in the world; any length but zero."""
    intensity: float
    """Share of a white surface's brightness when it faces the light."""
    color: Vector = (1.0, 1.0, 1.0)
    """rgb in 0..1."""

    def __post_init__(self) -> None:
        for name in ("direction", "color"):
            as_vector(getattr(self, name), 3, f"Light.{name}", InvalidCamera)
        as_number(self.intensity, "Light.intensity", InvalidCamera)
        if not np.linalg.norm(self.direction) > 1e-6:
            raise CameraError(f"A light needs a direction other than zero and finite numbers, not {self}.")
        if self.intensity < 0.0 or not all(0.0 <= c <= 1.0 for c in self.color):
            raise CameraError(f"A light has an intensity >= 0 and a colour in 0..1, not {self}.")

    @property
    def unit(self) -> NDArray[np.float64]:
        """Direction (3,) of length one."""
        vector = np.array(self.direction, dtype=float)
        return vector / np.linalg.norm(vector)

    def on(self, normals: NDArray) -> NDArray:
        """Brightness of surfaces with unit `normals` (..., 3)."""
        return np.maximum(normals @ self.unit.astype(normals.dtype), 0.0) * self.intensity


@dataclass(frozen=True)
class Lighting:
    """All light in a world."""

    key: Light = Light((0.6, 0.4, 1.6), 0.42)
    """The sun of the scene; casts the shadows."""
    fills: tuple[Light, ...] = field(default=(Light((-0.9, 0.8, 0.9), 0.10), Light((0.5, -1.2, 0.5), 0.10)))
    """Soft lights from the other sides."""
    ambient: float = 0.50
    """Brightness of a white surface that no light reaches."""

    def __post_init__(self) -> None:
        if not isinstance(self.fills, tuple | list) or not all(isinstance(light, Light) for light in (self.key, *self.fills)):
            raise CameraError("The key light and the fills of a `Lighting` are `Light`s.")
        as_number(self.ambient, "Lighting.ambient", InvalidCamera)
        if not 0.0 < self.ambient <= 1.0:
            raise CameraError(f"The ambient light lies above 0 and at most at 1, not at {self.ambient}.")

    @property
    def is_white(self) -> bool:
        """Whether no light has a colour."""
        return all(light.color == (1.0, 1.0, 1.0) for light in (self.key, *self.fills))

    @property
    def mean_fill(self) -> float:
        """What the fills give on average over all directions that things are seen from."""
        return 0.35 * sum(fill.intensity for fill in self.fills)
