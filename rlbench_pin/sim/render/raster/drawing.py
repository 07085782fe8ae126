"""Which triangle each pixel of some cameras sees, and how far away.

All triangles are projected for all cameras in one go, and the few that face one and hold the middle of a pixel are cut into spans
of pixels, row by row. With P the matrix of the homogeneous picture points (u z, v z, z) of its corners, 1/z is (1, 1, 1) P^-1
(u, v, 1), affine over a triangle, and any quantity q of the corners is q P^-1 (u, v, 1) z: perspective comes out right.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.raster.stage import Parts

_LEAST_AREA = 1e-4  # twice the area of a triangle that is drawn; smaller ones are slivers [px^2]


@dataclass(frozen=True, eq=False)
class Drawn:
    """The pixels of one camera that see a triangle, ascending."""

    pixels: NDArray[np.int64]
    """Flat indices (n,)."""
    triangles: NDArray[np.int64]
    """What they see (n,)."""
    inverse: NDArray[np.float32]
    """Inverse depth (n,) [1/m]."""
    normals: NDArray[np.float32]
    """Unit normals (3, n) in the world, between those of the corners."""


@dataclass(frozen=True, eq=False)
class _Outlines:
    """Triangles in pictures, clipped at the near plane."""

    x: NDArray[np.float32]
    """Columns (3, k) of the corners [px]."""
    y: NDArray[np.float32]
    """Rows (3, k) of the corners [px]."""
    owner: NDArray[np.int64]
    """Camera times number of triangles plus triangle (k,)."""


def draw(
    parts: Parts, shown: NDArray[np.bool_], placements: Mapping[tuple[int, int], NDArray], views: Sequence[CameraView]
) -> list[Drawn]:
    """Draw all triangles as some cameras see them; a picture is the same whatever other cameras look.

    Args:
        parts: The triangles.
        shown: Whether each visual is seen (n,).
        placements: Matrix (4, 4) of the frame of every link.
        views: The cameras.
    """
    corners = _projected(parts, placements, views)
    outlines = _outlines(corners, views, shown[parts.shape])
    widths, heights = np.array([view.size for view in views]).T
    starts = np.concatenate([[0], np.cumsum(widths * heights)])
    camera, triangle = np.divmod(outlines.owner, corners.shape[3])
    inverses = _inverses(corners, camera, triangle)
    spans = _Spans(outlines, widths[camera], heights[camera])
    pixels, owner, inverse = spans.nearest(
        inverses[0] + inverses[1] + inverses[2], starts[camera], widths[camera], int(starts[-1])
    )
    ends = np.searchsorted(pixels, starts)
    used = np.zeros(len(triangle), dtype=np.bool_)
    used[owner] = True
    number_of = np.cumsum(used) - 1
    forms = _forms(inverses[..., used], np.take(_normals(parts, placements), triangle[used], axis=2))
    drawn = []
    for number, view in enumerate(views):
        part = slice(ends[number], ends[number + 1])
        flat, which = pixels[part] - starts[number], owner[part]
        normals = _vectors(np.take(forms, number_of[which], axis=1), flat, view.size[0])
        drawn.append(Drawn(flat, triangle[which], inverse[part], normals))
    return drawn


def _normals(parts: Parts, placements: Mapping[tuple[int, int], NDArray]) -> NDArray[np.float32]:
    """Normals of all corners in the world, (3 corners, 3, m)."""
    result = np.empty_like(parts.normals)
    for link, part in zip(parts.links, parts.slices, strict=True):
        np.matmul(placements[link][:3, :3].astype(np.float32), parts.normals[:, :, part], out=result[:, :, part])
    return result


def _projected(parts: Parts, placements: Mapping[tuple[int, int], NDArray], views: Sequence[CameraView]) -> NDArray[np.float32]:
    """Homogeneous picture points u z, v z, z of every corner, camera and triangle, (3, c, 3, m)."""
    cameras = np.stack([view.to_picture for view in views])
    result = np.empty((3, len(views), 3, parts.corners.shape[2]), dtype=np.float32)
    for link, part in zip(parts.links, parts.slices, strict=True):
        # one product for each camera: larger ones are rounded otherwise
        np.matmul((cameras @ placements[link]).astype(np.float32), parts.corners[:, None, :, part], out=result[..., part])
    return result


def _outlines(corners: NDArray[np.float32], views: Sequence[CameraView], shown: NDArray[np.bool_]) -> _Outlines:
    """Triangles that face a camera and may hold the middle of one of its pixels."""
    depth = corners[:, :, 2]
    near = np.array([[view.near] for view in views], dtype=np.float32)
    least = _least(depth)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        x, y = corners[:, :, 0] / depth, corners[:, :, 1] / depth
        faces = _twice_area(x, y) < -_LEAST_AREA
    faces &= (least >= near) & shown
    edges = np.array([view.size for view in views], dtype=np.float32) - 1.0
    for values, last in ((x, edges[:, :1]), (y, edges[:, 1:])):
        low, high = np.ceil(_least(values)), _greatest(values)
        faces &= (low <= high) & (low <= last) & (high >= 0.0)
    chosen = np.flatnonzero(faces)
    outlines = _Outlines(x.reshape(3, -1)[:, chosen], y.reshape(3, -1)[:, chosen], chosen)
    crossing = np.flatnonzero((least < near) & (_greatest(depth) > near) & shown)
    return _joined([outlines, *_clipped(corners, crossing, near.ravel())]) if len(crossing) else outlines


def _least(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Smallest (...,) of the values (3, ...) of three corners."""
    return np.minimum(np.minimum(values[0], values[1]), values[2])


def _greatest(values: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.maximum(np.maximum(values[0], values[1]), values[2])


def _twice_area(x: NDArray, y: NDArray) -> NDArray:
    """Twice the area (...,) of triangles with corners (3, ...), negative where they are seen from the front."""
    return (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])


def _joined(outlines: Sequence[_Outlines]) -> _Outlines:
    return _Outlines(*(np.concatenate([getattr(o, name) for o in outlines], axis=-1) for name in ("x", "y", "owner")))


def _clipped(corners: NDArray[np.float32], crossing: NDArray[np.int64], near: NDArray[np.float32]) -> list[_Outlines]:
    """What of triangles that cross the near plane lies beyond it: triangles with one corner there, or quadrilaterals as two."""
    camera, triangle = np.divmod(crossing, corners.shape[3])
    points, limit = corners[:, camera, :, triangle], near[camera]  # (k, 3 corners, 3)
    beyond = points[:, :, 2] > limit[:, None]
    found: list[_Outlines] = []
    for inside in (1, 2):
        chosen = np.flatnonzero(beyond.sum(axis=1) == inside)
        # the corner that is alone on its side comes first
        first = np.argmax(beyond[chosen] == (inside == 1), axis=1)
        a, b, c = (points[chosen, (first + i) % 3] for i in range(3))
        ab, ac = (_cut(a, other, limit[chosen]) for other in (b, c))
        polygons = [(a, ab, ac)] if inside == 1 else [(ab, b, c), (ab, c, ac)]
        for polygon in polygons:
            p = np.stack(polygon)
            x, y = p[..., 0] / p[..., 2], p[..., 1] / p[..., 2]
            seen = _twice_area(x, y) < -_LEAST_AREA
            found.append(_Outlines(x[:, seen], y[:, seen], crossing[chosen][seen]))
    return found


def _cut(a: NDArray, b: NDArray, depth: NDArray) -> NDArray:
    """Points (k, 3) between a and b at some depth."""
    share = (depth - a[:, 2]) / (b[:, 2] - a[:, 2])
    return a + (b - a) * share[:, None]


def _inverses(corners: NDArray[np.float32], camera: NDArray[np.int64], triangle: NDArray[np.int64]) -> NDArray[np.float64]:
    """Inverse (3, 3, k) of matrices whose columns are the corners of some triangles as some cameras see them."""
    count = corners.shape[3]
    first = camera * (3 * count) + triangle
    flat = corners.reshape(3, -1)
    p = np.stack([np.take(flat, first + i * count, axis=1) for i in range(3)], axis=1).astype(np.float64)
    rows = np.empty_like(p)
    for i in range(3):
        a, b = p[(i + 1) % 3], p[(i + 2) % 3]
        for j in range(3):
            rows[i, j] = a[(j + 1) % 3] * b[(j + 2) % 3] - a[(j + 2) % 3] * b[(j + 1) % 3]
    determinant = p[0, 0] * rows[0, 0] + p[0, 1] * rows[0, 1] + p[0, 2] * rows[0, 2]
    rows /= np.where(determinant == 0.0, 1.0, determinant)
    return rows


class _Spans:
    """Runs of pixels in one row that lie in one triangle.

    Args:
        outlines: The triangles.
        widths: Width of the picture of each (k,) [px].
        heights: Height of the picture of each (k,) [px].
    """

    def __init__(self, outlines: _Outlines, widths: NDArray, heights: NDArray) -> None:
        y = outlines.y
        first = np.maximum(np.ceil(_least(y)), np.float32(0.0))
        last = np.minimum(np.floor(_greatest(y)), heights.astype(np.float32) - np.float32(1.0))
        counts = np.maximum(last - first + np.float32(1.0), np.float32(0.0)).astype(np.int64)
        ends = np.cumsum(counts)
        step = np.arange(ends[-1] if len(ends) else 0)
        step -= np.repeat(ends - counts, counts)
        low, high = _bounds(outlines.x, y, first, counts, step.astype(np.float32))
        np.maximum(np.ceil(low, out=low), np.float32(0.0), out=low)
        np.minimum(np.floor(high, out=high), np.repeat((widths - 1).astype(np.float32), counts), out=high)
        kept = np.flatnonzero(high >= low)
        low, high = low[kept], high[kept]
        self._owner = np.repeat(np.arange(len(counts)), counts)[kept]
        self._column = low.astype(np.int64)
        self._row = first[self._owner].astype(np.int64) + step[kept]
        self._length = (high - low).astype(np.int64) + 1

    def nearest(
        self, plane: NDArray[np.float64], starts: NDArray, widths: NDArray, size: int
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]:
        """Pixels that see something, ascending, the number of the outline that is nearest there, and inverse depth.

        Args:
            plane: Inverse depth of each outline is plane . (u, v, 1), (3, k).
            starts: Flat index of the first pixel of the picture of each outline (k,).
            widths: Width of that picture (k,) [px].
            size: Pixels of all pictures.
        """
        owner, length = self._owner, self._length
        begin = plane[0, owner] * self._column + plane[1, owner] * self._row + plane[2, owner]
        place = starts[owner] + self._row * widths[owner] + self._column
        ends = np.cumsum(length)
        offset = np.arange(ends[-1] if len(ends) else 0)
        offset -= np.repeat(ends - length, length)
        inverse = np.repeat(plane[0, owner].astype(np.float32), length)
        inverse *= offset
        inverse += np.repeat(begin.astype(np.float32), length)
        pixels = np.repeat(place, length)
        pixels += offset
        nearest = np.zeros(size, dtype=np.float32)
        np.maximum.at(nearest, pixels, inverse)
        wins = inverse == nearest[pixels]
        winner = np.empty(size, dtype=np.int64)
        winner[pixels[wins]] = np.repeat(owner, length)[wins]
        seen = np.flatnonzero(nearest > 0.0)
        return seen, winner[seen], nearest[seen]


def _bounds(
    x: NDArray[np.float32],
    y: NDArray[np.float32],
    first: NDArray[np.float32],
    counts: NDArray[np.int64],
    step: NDArray[np.float32],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """First and last column of rows of triangles [px].

    Edges that go down the picture bound from the left, those that go up from the right: one on one side, up to two on the other.

    Args:
        x: Columns (3, k) of the corners [px].
        y: Rows (3, k) of the corners [px].
        first: First row of each triangle (k,) [px].
        counts: Number of its rows (k,).
        step: Number of each row in its triangle (n,).
    """
    a, b, c = _from_top(x, y)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        edges = []
        for (x0, y0), (x1, y1) in ((a, c), (a, b), (b, c)):
            slope = (x1 - x0) / (y1 - y0)
            column = np.repeat(slope, counts)
            column *= step
            column += np.repeat(x0 + (first - y0) * slope, counts)
            edges.append(column)
        long, upper, lower = edges
        # level edges, nan or infinite here, bound nothing; the middle corner lies to the right of the long edge or to its left
        is_right = np.repeat((b[0] - a[0]) * (c[1] - a[1]) > (c[0] - a[0]) * (b[1] - a[1]), counts)
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


def _forms(inverses: NDArray[np.float64], values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Factors (9, k) of u, v and 1, three each, that give vectors between those of the corners, (3 corners, 3, k)."""
    weights = inverses.astype(np.float32)
    forms = weights[0][:, None] * values[0]
    for i in (1, 2):
        forms += weights[i][:, None] * values[i]
    return forms.reshape(9, -1)


def _vectors(forms: NDArray[np.float32], pixels: NDArray[np.int64], width: int) -> NDArray[np.float32]:
    """Unit vectors (3, n) at pixels, from their factors (9, n)."""
    row, column = np.divmod(pixels.astype(np.int32), np.int32(width))
    vectors = forms[:3] * column.astype(np.float32)
    vectors += forms[3:6] * row.astype(np.float32)
    vectors += forms[6:]
    x, y, z = vectors
    vectors /= np.maximum(np.sqrt(x * x + y * y + z * z), np.float32(1e-12))
    return vectors
