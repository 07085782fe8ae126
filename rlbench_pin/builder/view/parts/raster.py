"""Pictures of triangles with a depth for each pixel, so that what is nearer hides what is behind it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.spatial import FloatArray

_TIE = 2e-5
"""Surfaces that are nearer to one another are one; the later one, such as a label, is seen [m]."""


def painted(picture: NDArray[np.uint8], points: FloatArray, depths: FloatArray, shades: NDArray[np.uint8]) -> None:
    """Paint triangles over a picture.

    Args:
        picture: (height, width, 3), painted over.
        points: Corners (m, 3, 2) as x to the right and y downwards [px].
        depths: How near each corner is (m, 3) [m].
        shades: Colours (m, 3).
    """
    nearest = np.full(picture.shape[:2], -np.inf)
    size = np.array(picture.shape[1::-1])
    low = np.clip(np.floor(points.min(axis=1)), 0, size - 1).astype(int)
    high = np.clip(np.ceil(points.max(axis=1)) + 1, 1, size).astype(int)
    for (x0, y0), (x1, y1), corners, depth, shade in zip(low, high, points, depths, shades, strict=True):
        a, b, c = corners
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if abs(area) < 1e-9:
            continue
        x, y = np.arange(x0, x1) + 0.5, (np.arange(y0, y1) + 0.5)[:, None]
        second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
        third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
        here = depth[0] + second * (depth[1] - depth[0]) + third * (depth[2] - depth[0])
        seen = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1 + 1e-9) & (here >= nearest[y0:y1, x0:x1] - _TIE)
        nearest[y0:y1, x0:x1][seen] = here[seen]
        picture[y0:y1, x0:x1][seen] = shade
