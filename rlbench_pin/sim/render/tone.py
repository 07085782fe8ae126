"""Tone curve from brightness to bytes: linear up to 70 %, then compressed, so that white surfaces in full light keep shading."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_LINEAR, _MOST = 0.7, 1024
"""Up to which share of white bytes are proportional, and up to which brightness in 0..255 the table goes."""


def _curve() -> NDArray[np.uint8]:
    brightness = np.arange(_MOST) / 255.0
    rest = 1.0 - _LINEAR
    shoulder = _LINEAR + rest * (1.0 - np.exp(-(brightness - _LINEAR) / rest))
    return np.rint(255.0 * np.where(brightness < _LINEAR, brightness, shoulder)).astype(np.uint8)


_CURVE = _curve()


def toned(colors: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return the bytes of colours in 0..255 and above, of any shape; overwrites them."""
    colors += np.float32(0.5)
    return _CURVE.take(colors.astype(np.int64), mode="clip")
