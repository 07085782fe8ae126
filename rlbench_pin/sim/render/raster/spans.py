"""Runs of pixels in one row that lie in one triangle, and which of them is nearest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.raster.outlines import Outlines

_BITS = 32
"""Bits of the number of a triangle in a key; above them are those of its inverse depth."""
_LEAST_INVERSE = np.float32(1e-9)
"""What slivers are never beyond [1/m]."""


class Spans:
    """Runs of pixels in one row that lie in one triangle.

    Args:
        outlines: The triangles.
        widths: Width of the picture of each (k,) [px].
        heights: Height of the picture of each (k,) [px].
    """

    def __init__(self, outlines: Outlines, widths: NDArray, heights: NDArray) -> None:
        y = outlines.y
        first = np.maximum(np.ceil(y.min(axis=0)), np.float32(0.0))
        last = np.minimum(np.floor(y.max(axis=0)), heights.astype(np.float32) - np.float32(1.0))
        counts = np.maximum(last - first + np.float32(1.0), np.float32(0.0)).astype(np.int64)
        owner, step = _runs(counts)
        low, high = _bounds(outlines.x, y, first, owner, step.astype(np.float32))
        np.maximum(np.ceil(low, out=low), np.float32(0.0), out=low)
        np.minimum(np.floor(high, out=high), (widths - 1).astype(np.float32).take(owner), out=high)
        kept = (high >= low).nonzero()[0]
        low, high = low.take(kept), high.take(kept)
        self._triangle = outlines.triangle
        self._owner = owner.take(kept)
        self._column = low.astype(np.int64)
        self._row = first.astype(np.int64).take(self._owner) + step.take(kept)
        self._length = (high - low).astype(np.int64) + 1

    def draw_into(self, nearest: NDArray[np.int64], plane: NDArray[np.float64], starts: NDArray, widths: NDArray) -> None:
        """Put the key of each triangle where it is greater than what is there.

        Keys are ordered by inverse depth; of triangles that are equally near that with the highest number is seen.

        Args:
            nearest: Greatest key (n,) of each pixel of all pictures so far, 0 for none; changed here.
            plane: Inverse depth of each outline is plane . (u, v, 1), (3, k).
            starts: Flat index of the first pixel of the picture of each outline (k,).
            widths: Width of that picture (k,) [px].
        """
        slope, down, shift = plane.take(self._owner, axis=1)
        begin = slope * self._column + down * self._row + shift
        place = starts.take(self._owner) + self._row * widths.take(self._owner) + self._column
        span, offset = _runs(self._length)
        inverse = slope.astype(np.float32).take(span)
        inverse *= offset.astype(np.float32)
        inverse += begin.astype(np.float32).take(span)
        np.fmax(inverse, _LEAST_INVERSE, out=inverse)
        offset += place.take(span)
        # numbers above zero are ordered as their bits are
        key = inverse.view(np.int32).astype(np.int64)
        key <<= _BITS
        key |= self._triangle.take(self._owner).take(span)
        np.maximum.at(nearest, offset, key)


def parts_of_keys(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Triangle and inverse depth [1/m] of keys (n,) above 0."""
    return keys & ((1 << _BITS) - 1), (keys >> _BITS).astype(np.int32).view(np.float32)


def _runs(counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Number of the run of each of its members, and the number of the member in its run, both (sum of counts,)."""
    owner = np.repeat(np.arange(len(counts)), counts)
    step = np.arange(len(owner))
    step -= (np.cumsum(counts) - counts).take(owner)
    return owner, step


def _bounds(
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    first: NDArray[np.float32],
    owner: NDArray[np.int64],
    step: NDArray[np.float32],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """First and last column of rows of triangles [px].

    Edges that go down the picture bound from the left, those that go up from the right: one on one side, up to two on the other.

    Args:
        x: Columns (3, k) of the corners [px].
        y: Rows (3, k) of the corners [px].
        first: First row of each triangle (k,) [px].
        owner: Triangle of each row (n,).
        step: Number of each row in its triangle (n,).
    """
    a, b, c = _from_top(x, y)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        edges = []
        for (x0, y0), (x1, y1) in ((a, c), (a, b), (b, c)):
            slope = (x1 - x0) / (y1 - y0)
            column = slope.take(owner)
            column *= step
            column += (x0 + (first - y0) * slope).take(owner)
            edges.append(column)
        long, upper, lower = edges
        # level edges, nan or infinite here, bound nothing; the middle corner lies to the right of the long edge or to its left
        is_right = ((b[0] - a[0]) * (c[1] - a[1]) > (c[0] - a[0]) * (b[1] - a[1])).take(owner)
        return np.where(is_right, long, np.fmax(upper, lower)), np.where(is_right, np.fmin(upper, lower), long)


def _from_top(x: NDArray[np.float32], y: NDArray[np.float32]) -> list[tuple[NDArray[np.float32], NDArray[np.float32]]]:
    """Columns and rows of the corners of triangles, the upper corners first."""
    corners = list(zip(x, y, strict=True))
    for i, j in ((0, 1), (1, 2), (0, 1)):
        (xi, yi), (xj, yj) = corners[i], corners[j]
        swaps = yi > yj
        corners[i] = np.where(swaps, xj, xi), np.where(swaps, yj, yi)
        corners[j] = np.where(swaps, xi, xj), np.where(swaps, yi, yj)
    return corners
