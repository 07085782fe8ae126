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


def distance(color: FloatArray, name: str) -> float:
    """Return how far a colour (3,) is from a named one; light and shade change the brightness, less than the hue."""
    wanted = PALETTE[name]
    brightness = float(color.max() - wanted.max())
    hue = color / max(float(color.max()), 0.08) - wanted / max(float(wanted.max()), 0.08)
    weight = min(1.0, float(max(color.max(), wanted.max())))
    return float(np.linalg.norm(hue)) * weight + abs(brightness)


def name_of(color: FloatArray, names: Sequence[str] = tuple(PALETTE)) -> str:
    """Return the nearest of some colour words."""
    return min(names, key=lambda name: distance(color, name))
