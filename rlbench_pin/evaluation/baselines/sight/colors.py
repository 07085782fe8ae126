"""Names of colours under light and shade."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import COLORS

PALETTE = {color.name: np.array(color.rgb) for color in COLORS}
"""Colour words and their red, green, blue from 0 to 1."""
BRIGHT = 75.0
"""Percentile of brightness of the points that are compared: those that the light falls on."""


def lit_color(colors: FloatArray) -> FloatArray:
    """Return the colour (3,) of the brighter points of a surface (n, 3)."""
    brightness = colors.sum(axis=1)
    bright = colors[brightness >= np.percentile(brightness, BRIGHT)]
    color: FloatArray = np.median(bright, axis=0)
    return color


def distances(colors: FloatArray, name: str) -> FloatArray:
    """Return how far colours (..., 3) are from a named one; light and shade change the brightness, less than the hue."""
    wanted = PALETTE[name]
    brightest = colors.max(axis=-1)
    hue = colors / np.maximum(brightest, 0.08)[..., None] - wanted / max(float(wanted.max()), 0.08)
    weight = np.minimum(1.0, np.maximum(brightest, wanted.max()))
    far: FloatArray = np.linalg.norm(hue, axis=-1) * weight + np.abs(brightest - wanted.max())
    return far


def name_of(color: FloatArray, names: Sequence[str] = tuple(PALETTE)) -> str:
    """Return the nearest of some colour words."""
    return min(names, key=lambda name: float(distances(color, name)))
