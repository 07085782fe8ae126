"""Triangles in the images of some cameras: projected, clipped at the near plane, and cut into runs of pixels.

Triangles outside of all images are left out. In each pixel the nearest triangle is kept.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.raster.stage import Placed

_MIN_AREA = 1e-4  # twice the area of a triangle that is drawn; smaller ones are slivers [px^2]
_EDGE = np.float32(1.0)  # this far outside an image nothing is drawn any more [px]


@dataclass(frozen=True, eq=False)
class Outlines:
    """Triangles in images, clipped at the near plane."""

    x: NDArray[np.float32]
    """Columns (3, k) of the corners [px]."""
    y: NDArray[np.float32]
    """Rows (3, k) of the corners [px]."""
    camera: NDArray[np.int64]
    """Number of the camera (k,)."""
    triangle: NDArray[np.int64]
    """Number of the triangle (k,)."""


class Projection:
    """Triangles projected into some cameras.

    Args:
        placed: The triangles.
        views: The cameras.

    Attributes:
        views: The same.
        normals: Normals of the corners in the world, (3 corners, 3, m).
        surface: Values of `Parts.surface` at the corners, (3 corners, c, m).
        corner_points: Numbers (3, m) of the points at the corners of the triangles.
        facing: Whether each camera (c, m) is on the side from which a triangle is seen.
        reached: Whether something of each link (l,) may be in the image of each camera, (c, l).
        close: Whether some points are in front of the near plane of each camera (c,).
    """

    def __init__(self, placed: Placed, views: Sequence[CameraView]) -> None:
        self.views, self.corner_points = views, placed.parts.corners
        self.normals, self.surface = placed.normals, placed.parts.surface
        cameras = np.stack([view.to_image for view in views]).astype(np.float32)
        # one product for each camera: larger ones are rounded otherwise
        points = np.matmul(cameras, placed.points)
        eyes = np.ones((len(views), 1, 4), dtype=np.float32)
        eyes[:, 0, :3] = [view.pose[:3] for view in views]
        self.facing: NDArray[np.bool_] = np.matmul(eyes, placed.planes)[:, 0] > 0.0
        self.reached = _reached(views, placed)
        self._count, self._slices = points.shape[2], placed.parts.point_slices
        self._points = points.ravel()
        near = np.array([view.near for view in views], dtype=np.float32)
        self.close = ~(points[:, 2].min(axis=1) >= near) if self._count else np.zeros(len(views), dtype=np.bool_)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            self._pixels = (points[:, :2] / points[:, 2:]).ravel()

    def bounds(self, camera: int, links: NDArray[np.bool_]) -> tuple[tuple[int, int], tuple[int, int]]:
        """First and last column, and first and last row, of the part of an image that contains all points of some links (l,)."""
        pixels = self._pixels[2 * camera * self._count : 2 * (camera + 1) * self._count].reshape(2, -1)
        if not links.all():
            pixels = np.concatenate(
                [pixels[:, :0], *(pixels[:, own] for own, is_one in zip(self._slices, links) if is_one)], axis=1
            )
        if not pixels.shape[1]:
            return (0, 0), (0, 0)
        spans = []
        for low, high, side in zip(pixels.min(axis=1), pixels.max(axis=1), self.views[camera].size, strict=True):
            is_known = np.isfinite(low) and np.isfinite(high)
            ends = (math.floor(low), math.ceil(high)) if is_known else (0, side - 1)
            spans.append([min(max(end, 0), side - 1) for end in ends])
        columns, rows = spans
        return (columns[0], rows[0]), (columns[1], rows[1])

    def image(self, camera: NDArray[np.int64], triangle: NDArray[np.int64]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Columns and rows (3, k) of the corners of triangles [px]; infinite or nan behind a camera."""
        place = self.corner_points.take(triangle, axis=1)
        place += camera * (2 * self._count)
        x = self._pixels.take(place)
        place += self._count
        return x, self._pixels.take(place)

    def depth(self, camera: int, triangle: NDArray[np.int64]) -> NDArray[np.float32]:
        """Depth (3, k) of the corners of triangles before one camera [m]."""
        begin = (3 * camera + 2) * self._count
        return self._points[begin : begin + self._count].take(self.corner_points.take(triangle, axis=1))

    def corners(self, camera: NDArray[np.int64], triangle: NDArray[np.int64]) -> NDArray[np.float64]:
        """Homogeneous image points u z, v z and z of the corners of triangles, (3 corners, 3, k)."""
        place = self.corner_points.take(triangle, axis=1)
        place += camera * (3 * self._count)
        result = np.empty((3, 3, len(triangle)))
        for i in range(3):
            result[:, i] = self._points.take(place + i * self._count)
        return result


def _reached(views: Sequence[CameraView], placed: Placed) -> NDArray[np.bool_]:
    """Whether the ball around each link may reach into the pyramid of each camera (c, l), with a pixel to spare."""
    sides = np.stack([view.sides for view in views]).astype(np.float32)
    inside = np.matmul(sides, placed.middles) + placed.parts.balls[:, 3]
    result: NDArray[np.bool_] = inside.min(axis=1) > 0.0
    return result


def outlines_of(projection: Projection, wanted: NDArray[np.bool_]) -> Outlines:
    """Triangles of those that each camera wants (c, m) that face it and may hold the middle of one of its pixels."""
    each = [faces.nonzero()[0] for faces in projection.facing & wanted]
    counts = [len(triangles) for triangles in each]
    triangle, camera = np.concatenate(each), np.repeat(np.arange(len(each)), counts)
    x, y = projection.image(camera, triangle)
    chosen = np.ones(len(triangle), dtype=np.bool_)
    crossing = []
    ends = np.cumsum([0, *counts]).tolist()
    for number in projection.close.nonzero()[0].tolist():
        part, near = slice(ends[number], ends[number + 1]), np.float32(projection.views[number].near)
        depth = projection.depth(number, triangle[part])
        chosen[part] = is_before = _least(depth) >= near
        crossing.append((~is_before & (_greatest(depth) > near)).nonzero()[0] + part.start)
    for values, axis in ((x, 0), (y, 1)):
        last = np.repeat(np.array([view.size[axis] - 1 for view in projection.views], dtype=np.float32), counts)
        low, high = np.ceil(_least(values)), _greatest(values)
        chosen &= (low <= high) & (low <= last) & (high >= 0.0)
    chosen &= _twice_area(x, y) < -_MIN_AREA
    whole = chosen.nonzero()[0]
    outlines = Outlines(x.take(whole, axis=1), y.take(whole, axis=1), camera.take(whole), triangle.take(whole))
    if not sum(len(own) for own in crossing):
        return outlines
    cut = np.concatenate(crossing)
    return _joined([outlines, *_clipped(projection, camera.take(cut), triangle.take(cut))])


def _least(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Smallest (...,) of the values (3, ...) of three corners."""
    return np.minimum(np.minimum(values[0], values[1]), values[2])


def _greatest(values: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.maximum(np.maximum(values[0], values[1]), values[2])


def _twice_area(x: NDArray, y: NDArray) -> NDArray:
    """Twice the area (...,) of triangles with corners (3, ...), negative where they are seen from the front."""
    with np.errstate(invalid="ignore", over="ignore"):
        area: NDArray = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    return area


def _joined(outlines: Sequence[Outlines]) -> Outlines:
    return Outlines(*(np.concatenate([getattr(o, name) for o in outlines], axis=-1) for name in ("x", "y", "camera", "triangle")))


def _clipped(projection: Projection, camera: NDArray[np.int64], triangle: NDArray[np.int64]) -> list[Outlines]:
    """Parts of triangles beyond the near plane: triangles with one corner there, or quadrilaterals as two."""
    points = projection.corners(camera, triangle)
    inside = np.flatnonzero(_reaches_in(points, np.array([view.size for view in projection.views]).take(camera, axis=0)))
    if not len(inside):
        return []
    camera, triangle = camera.take(inside), triangle.take(inside)
    limit = np.array([view.near for view in projection.views]).take(camera)
    points = points.take(inside, axis=2).transpose(2, 0, 1)  # (k, 3 corners, 3)
    beyond = points[:, :, 2] > limit[:, None]
    found: list[Outlines] = []
    for count in (1, 2):
        chosen = np.flatnonzero(beyond.sum(axis=1) == count)
        # the corner that is alone on its side comes first
        first = np.argmax(beyond[chosen] == (count == 1), axis=1)
        a, b, c = (points[chosen, (first + i) % 3] for i in range(3))
        ab, ac = (_cut(a, other, limit[chosen]) for other in (b, c))
        polygons = [(a, ab, ac)] if count == 1 else [(ab, b, c), (ab, c, ac)]
        for polygon in polygons:
            p = np.stack(polygon).astype(np.float32)
            x, y = p[..., 0] / p[..., 2], p[..., 1] / p[..., 2]
            seen = np.flatnonzero(_twice_area(x, y) < -_MIN_AREA)
            kept = chosen.take(seen)
            found.append(Outlines(x.take(seen, axis=1), y.take(seen, axis=1), camera.take(kept), triangle.take(kept)))
    return found


def _reaches_in(points: NDArray[np.float64], sizes: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether triangles (k,) may be in the view frustum of a camera: not all corners are outside of one of its sides.

    Args:
        points: Homogeneous image points (3 corners, 3, k).
        sizes: Width and height (k, 2) of the images [px].
    """
    x, y, z = points.transpose(1, 0, 2)
    result = np.ones(len(sizes), dtype=np.bool_)
    for values, last in ((x, sizes[:, 0]), (y, sizes[:, 1])):
        result &= (values + _EDGE * z > 0.0).any(axis=0) & (values < last * z).any(axis=0)
    return result


def _cut(a: NDArray, b: NDArray, depth: NDArray) -> NDArray:
    """Points (k, 3) between a and b at some depth."""
    share = (depth - a[:, 2]) / (b[:, 2] - a[:, 2])
    return a + (b - a) * share[:, None]


_BITS = 32
"""Bits of the number of a triangle in a key; above them are those of its inverse depth."""
_UPPER = 1 if sys.byteorder == "little" else 0
"""Which half of a key is that of the inverse depth."""
_MIN_INVERSE = np.float32(1e-9)
"""What slivers are never beyond [1/m]."""


class Spans:
    """Runs of pixels in one row of one triangle.

    Args:
        outlines: The triangles.
        widths: Width of the image of each (k,) [px].
        heights: Height of the image of each (k,) [px].
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
        """Write the key of each triangle where it is greater than the present key.

        Keys are ordered by inverse depth; of equally near triangles the one with the highest number is visible.

        Args:
            nearest: Greatest key (n,) of each pixel of all images so far, 0 for none; changed here.
            plane: Inverse depth of each outline is plane . (u, v, 1), (3, k).
            starts: Flat index of the first pixel of the image of each outline (k,).
            widths: Width of that image (k,) [px].
        """
        slope, down, shift = plane.take(self._owner, axis=1)
        begin = slope * self._column + down * self._row + shift
        place = starts.take(self._owner) + self._row * widths.take(self._owner) + self._column
        span, offset = _runs(self._length)
        inverse = slope.astype(np.float32).take(span)
        inverse *= offset.astype(np.float32)
        inverse += begin.astype(np.float32).take(span)
        np.fmax(inverse, _MIN_INVERSE, out=inverse)
        offset += place.take(span)
        # numbers above zero are ordered as their bits are
        key = inverse.view(np.int32).astype(np.int64)
        key <<= _BITS
        key |= self._triangle.take(self._owner).take(span)
        np.maximum.at(nearest, offset, key)


def parts_of_keys(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Triangle and inverse depth [1/m] of keys (n,) above 0."""
    return keys & ((1 << _BITS) - 1), inverses_of_keys(keys)


def inverses_of_keys(keys: NDArray[np.int64]) -> NDArray[np.float32]:
    """Inverse depth [1/m] of keys (...); 0 where they are 0."""
    halves: NDArray[np.float32] = np.ascontiguousarray(keys).view(np.float32).reshape(*keys.shape, 2)
    return halves[..., _UPPER]


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

    Edges that go down the image bound from the left, those that go up from the right: one on one side, up to two on the other.

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
        return _chosen(is_right, long, np.fmax(upper, lower)), _chosen(is_right, np.fmin(upper, lower), long)


def _from_top(x: NDArray[np.float32], y: NDArray[np.float32]) -> list[tuple[NDArray[np.float32], NDArray[np.float32]]]:
    """Columns and rows of the corners of triangles, the upper corners first."""
    corners = list(zip(x, y, strict=True))
    for i, j in ((0, 1), (1, 2), (0, 1)):
        (xi, yi), (xj, yj) = corners[i], corners[j]
        swaps = yi > yj
        corners[i] = _chosen(swaps, xj, xi), _chosen(swaps, yj, yi)
        corners[j] = _chosen(swaps, xi, xj), _chosen(swaps, yi, yj)
    return corners


def _chosen(is_first: NDArray[np.bool_], first: NDArray[np.float32], second: NDArray[np.float32]) -> NDArray[np.float32]:
    """Same result as `np.where`, bit by bit: several times as fast where the choice has no pattern."""
    bits, others = first.view(np.int32), second.view(np.int32)
    result = bits ^ others
    result &= np.negative(is_first.view(np.int8)).astype(np.int32)
    result ^= others
    return result.view(np.float32)
