"""Visibility: the triangle in each pixel of some cameras, and its depth.

All points are projected for all cameras at once. The triangles that face a camera and cover the centre of a pixel are cut into
spans of pixels, row by row. With P the matrix of the homogeneous image points (u z, v z, z) of its corners, 1/z is
(1, 1, 1) P^-1 (u, v, 1), affine over a triangle, and any quantity q of the corners is q P^-1 (u, v, 1) z, which is correct in
perspective. Stationary links in front of a stationary camera are drawn once: the keys of their pixels, which merge by the
maximum, are cached in layers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.raster.spans import Projection, Spans, inverses_of_keys, outlines_of, parts_of_keys
from rlbench_pin.sim.render.raster.stage import Layer, Layers, Placed

TOUCHING = np.float32(1e-5)
"""So far behind the room objects are still seen [m]."""


_SOLID = np.float32(0.999)
"""From this opacity on nothing is seen through a surface."""


@dataclass(frozen=True, eq=False)
class CameraGroup:
    """Cameras with equal requests."""

    views: Sequence[CameraView]
    """The cameras."""
    is_lit: bool = False
    """Whether colours are wanted."""
    ambient: float = 1.0
    """Brightness where the key light does not reach, for renderers that light what they draw."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """The pixels of some cameras that show a triangle, camera by camera; then those of glass in front of the others."""

    ends: NDArray[np.int64]
    """Which pixels are the first of each camera (c + 1,), or (2 c + 1,) where there is glass."""
    pixels: NDArray[np.int64]
    """Flat indices (n,), image after image; those of a camera ascend."""
    triangles: NDArray[np.int64]
    """What they see (n,)."""
    inverse: NDArray[np.float32]
    """Inverse depth (n,) [1/m]."""
    depth: NDArray[np.float32]
    """(n,) [m]."""
    row: NDArray[np.float32]
    """Rows of the pixels in their images (n,)."""
    column: NDArray[np.float32]
    """Their columns (n,)."""
    place: NDArray[np.int64]
    """Which of the forms each pixel has (n,); none where no colours are wanted."""
    forms: NDArray[np.float32]
    """Factors (k, 3 c) of column, row and 1, c each, that give normals and values of `Parts.surface`, over the depth."""

    def normals(self) -> NDArray[np.float32]:
        """Return unit normals (3, n) in the world, between those of the corners."""
        vectors = self._between(range(3), slice(None))
        x, y, z = vectors
        vectors /= np.maximum(np.sqrt(x * x + y * y + z * z), np.float32(1e-12))
        return vectors

    def surface(self, numbers: Sequence[int], chosen: NDArray[np.int64] | slice) -> NDArray[np.float32]:
        """Return some values (c, k) of `Parts.surface` of some pixels, between those of the corners."""
        values = self._between([3 + number for number in numbers], chosen)
        values /= self.inverse[chosen]
        return values

    def _between(self, numbers: Sequence[int], chosen: NDArray[np.int64] | slice) -> NDArray[np.float32]:
        u, v, forms = self.column[chosen], self.row[chosen], self.forms.take(self.place[chosen], axis=0)
        count = forms.shape[1] // 3
        result = np.empty((len(numbers), len(u)), dtype=np.float32)
        for i, values in zip(numbers, result, strict=True):
            np.multiply(forms[:, i], u, out=values)
            values += forms[:, count + i] * v
            values += forms[:, 2 * count + i]
        return result


@dataclass(frozen=True, eq=False)
class Blocked:
    """Where moving objects block a light, in a part of its image."""

    row: int
    """First row of the part."""
    column: int
    """Its first column."""
    depth: NDArray[np.float32]
    """Distance along the light to the first object, infinite where there is none, (h, w) [m]."""


class Targets:
    """The keys of the pixels of all cameras, in one row.

    Args:
        projection: The projected triangles.
        moving: Which links (l,) move in the image of the last camera if that is the camera of a light; only where these are it
            is drawn.

    Attributes:
        keys: The keys (n,).
        starts: Where those of each camera begin (c + 1,).
    """

    def __init__(self, projection: Projection, moving: NDArray[np.bool_] | None) -> None:
        self.sizes = np.array([view.size for view in projection.views])
        self.windows = [(slice(0, height), slice(0, width)) for width, height in self.sizes.tolist()]
        if moving is not None:
            (left, top), (right, bottom) = projection.bounds(len(self.windows) - 1, moving)
            # whole blocks of four by four
            self.windows[-1] = slice(top & ~3, (bottom + 4) & ~3), slice(left & ~3, (right + 4) & ~3)
        shapes = [(rows.stop - rows.start, columns.stop - columns.start) for rows, columns in self.windows]
        self._widths = np.array([width for _, width in shapes])
        self.starts = np.cumsum([0, *(height * width for height, width in shapes)])
        corners = [(rows.start, columns.start) for rows, columns in self.windows]
        self._origins = self.starts[:-1] - [row * width + column for (row, column), (_, width) in zip(corners, shapes)]
        self.keys = np.empty(int(self.starts[-1]), dtype=np.int64)
        self.images = [self.keys[a:b].reshape(shape) for a, b, shape in zip(self.starts, self.starts[1:], shapes)]

    def draw(self, keys: NDArray[np.int64], projection: Projection, wanted: NDArray[np.bool_]) -> None:
        """Draw the triangles that each camera wants (c, m) into keys (n,)."""
        outlines = outlines_of(projection, wanted)
        camera = outlines.camera
        widths, heights = self.sizes.T
        spans = Spans(outlines, widths.take(camera), heights.take(camera))
        planes = _inverse_depths(projection.corners(camera, outlines.triangle))
        spans.draw_into(keys, planes, self._origins.take(camera), self._widths.take(camera))


class Drawing:
    """All triangles from some cameras; an image depends neither on the other cameras nor on earlier drawings.

    Args:
        placed: The triangles.
        layers: The cached drawings.
        opacity: Of each triangle (m,): 0 is invisible, 1 is opaque, values between are glass, which casts no shadow.
        views: The cameras.
        light: Camera of a light, if one is to be drawn.
    """

    def __init__(
        self,
        placed: Placed,
        layers: Layers,
        opacity: NDArray[np.float32],
        views: Sequence[CameraView],
        light: CameraView | None,
    ) -> None:
        projection = self._projection = Projection(placed, [*views, *([] if light is None else [light])])
        solid, glass = opacity >= _SOLID, (opacity > 0.0) & (opacity < _SOLID)
        self._layers = layers.of(projection.views, solid, placed.still)
        kept = self._layers[-1]
        moving = np.ones(len(placed.still), dtype=np.bool_) if kept is None else ~kept.links
        targets = self._targets = Targets(projection, None if light is None else moving)
        targets.draw(targets.keys, projection, solid & _from_layers(targets, projection, placed, self._layers, solid))
        self._front = None
        if glass.any():
            front = self._front = targets.keys.copy()
            is_camera = np.arange(len(projection.views)) < len(views)
            targets.draw(front, projection, glass & is_camera[:, None])
            front[front == targets.keys] = 0

    def states(self) -> tuple[object | None, ...]:
        """Return for each camera, the light last, an object that stays the same while the same links are stationary, or None."""
        return tuple(None if layer is None else layer.state for layer in self._layers)

    def blocked(self) -> Blocked:
        """Return where moving links block the light."""
        rows, columns = self._targets.windows[-1]
        return _blocked(rows.start, columns.start, self._targets.images[-1])

    def all_blocked(self, stationary: bool = False) -> Blocked:
        """Return where all links, or only stationary ones, block the light."""
        if self._layers[-1] is None:
            return self.blocked()
        keys = self._kept(-1).nearest
        if not stationary:
            keys = keys.copy()
            keys[self._targets.windows[-1]] = self._targets.images[-1]
        rows, columns = (_extent(np.asarray(keys.any(axis=axis))) for axis in (1, 0))
        return _blocked(rows.start, columns.start, keys[rows, columns])

    def changed(self) -> NDArray[np.bool_]:
        """Return for each block of four by four pixels of the image of the light whether moving links are there."""
        rows, columns = self._targets.windows[-1]
        differs = self._targets.images[-1] != self._kept(-1).nearest[rows, columns]
        blocks = np.ascontiguousarray(differs).view(np.uint32)
        blocks = (blocks[0::4] | blocks[1::4] | blocks[2::4] | blocks[3::4]) != 0
        width, height = self._projection.views[-1].size
        every = np.zeros((height // 4, width // 4), dtype=np.bool_)
        every[rows.start // 4 : rows.stop // 4, columns.start // 4 : columns.stop // 4] = blocks
        return every

    def seen(
        self, camera_group: CameraGroup, first: int, limit: NDArray[np.float32] | None, again: NDArray[np.int64] | None = None
    ) -> Drawn:
        """Return the visible triangles of some cameras.

        Args:
            camera_group: The cameras.
            first: Number of the first of them.
            limit: Depth of the room in all their pixels (n,), image after image, which hides farther triangles [m]; None hides
                nothing.
            again: With it stationary links are left out in the pixels of cameras with layers, but for these pixels (k,).
        """
        targets = self._targets
        part = slice(targets.starts[first], targets.starts[first + len(camera_group.views)])
        keys = targets.keys[part]
        is_seen = keys > 0
        if again is not None:
            for number in range(first, first + len(camera_group.views)):
                layer, begin = self._layers[number], targets.starts[number]
                if layer is not None:
                    own = slice(begin - part.start, targets.starts[number + 1] - part.start)
                    is_seen[own] &= keys[own] != layer.nearest.ravel()
            is_seen[again] = True
        if self._front is None:
            return _drawn(keys, is_seen, camera_group, first, limit, self._projection)
        front = self._front[part]
        return _drawn(
            np.concatenate([keys, front]), np.concatenate([is_seen, front > 0]), camera_group, first, limit, self._projection
        )

    def stationary(self, camera_group: CameraGroup, first: int, limit: NDArray[np.float32]) -> Drawn:
        """Return the visible stationary links of cameras with layers, in front of a depth of all pixels (n,) [m]."""
        layers = self._layers[first : first + len(camera_group.views)]
        each = zip(layers, camera_group.views, strict=True)
        keys = np.concatenate(
            [np.zeros(view.size[0] * view.size[1], np.int64) if own is None else own.nearest.ravel() for own, view in each]
        )
        return _drawn(keys, keys > 0, camera_group, first, limit, self._projection)

    def _kept(self, number: int) -> Layer:
        layer = self._layers[number]
        assert layer is not None
        return layer


def _drawn(
    keys: NDArray[np.int64],
    is_seen: NDArray[np.bool_],
    camera_group: CameraGroup,
    first: int,
    limit: NDArray[np.float32] | None,
    projection: Projection,
) -> Drawn:
    """Return the visible triangles of some cameras in front of the room.

    Args:
        keys: Keys of their pixels (n,), and where there is glass, those of glass in front of them (2 n,).
        is_seen: Which of these to look at.
        camera_group: The cameras.
        first: Number of the first of them.
        limit: Depth of the pixels (n,) from which on nothing is seen [m].
        projection: The triangles.
    """
    counts = [view.size[0] * view.size[1] for view in camera_group.views]
    cameras = np.arange(first, first + len(counts))
    has_glass = len(keys) > sum(counts)
    if has_glass:
        counts, cameras = counts * 2, np.concatenate([cameras, cameras])
    pixels = is_seen.nonzero()[0]
    triangles, inverse = parts_of_keys(keys.take(pixels))
    depth: NDArray[np.float32] = np.float32(1.0) / inverse
    ends = np.searchsorted(pixels, np.cumsum([0, *counts]))
    if has_glass:
        pixels[ends[len(camera_group.views)] :] -= len(keys) // 2
    if limit is not None:
        seen = depth < limit.take(pixels) + TOUCHING
        if not seen.all():
            kept = seen.nonzero()[0]
            pixels, triangles = pixels.take(kept), triangles.take(kept)
            inverse, depth = inverse.take(kept), depth.take(kept)
            ends = np.searchsorted(kept, ends)
    rows, columns = _grid(tuple(view.size for view in camera_group.views))
    place, forms = _no_forms() if not camera_group.is_lit else _forms(triangles, np.repeat(cameras, np.diff(ends)), projection)
    return Drawn(ends, pixels, triangles, inverse, depth, rows.take(pixels), columns.take(pixels), place, forms)


@lru_cache(maxsize=8)
def _grid(sizes: tuple[tuple[int, int], ...]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Row and column of every pixel (n,) of images of some sizes, image after image."""
    each = [np.indices((height, width), dtype=np.float32).reshape(2, -1) for width, height in sizes]
    rows, columns = np.concatenate(each, axis=1)
    return rows, columns


def _extent(is_used: NDArray[np.bool_]) -> slice:
    """From the first to the last."""
    used = is_used.nonzero()[0].tolist()
    return slice(used[0], used[-1] + 1) if used else slice(0, 0)


def _blocked(row: int, column: int, keys: NDArray[np.int64]) -> Blocked:
    """Surfaces in the light, from the keys of a part of its pixels."""
    with np.errstate(divide="ignore"):
        return Blocked(row, column, np.float32(1.0) / inverses_of_keys(keys))


def _from_layers(
    targets: Targets, projection: Projection, placed: Placed, kept: Sequence[Layer | None], shown: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Fill all images of stationary cameras with their stationary links.

    Returns:
        Which triangles are still to be drawn, (c, m).
    """
    link = placed.parts.link
    missing = np.zeros((len(kept), len(placed.still)), dtype=np.bool_)
    for number, (layer, own) in enumerate(zip(kept, targets.images, strict=True)):
        if layer is not None:
            missing[number] = placed.still & ~layer.links
        if layer is None or missing[number].any():
            own[:] = 0
    if missing.any():
        targets.draw(targets.keys, projection, shown & missing.take(link, axis=1))
    left = np.ones((len(kept), len(placed.still)), dtype=np.bool_)
    for number, (layer, own, window) in enumerate(zip(kept, targets.images, targets.windows, strict=True)):
        if layer is None:
            continue
        stationary = layer.nearest[window]
        if missing[number].any():
            np.maximum(stationary, own, out=stationary)
            layer.add(missing[number])
        own[:] = stationary
        left[number] = ~layer.links
    return (left & projection.reached).take(link, axis=1)


def _no_forms() -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    return np.zeros(0, dtype=np.int64), np.zeros((0, 9), dtype=np.float32)


def _forms(
    triangles: NDArray[np.int64], camera: NDArray[np.int64], projection: Projection
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Which form each of some triangles (n,) in the image of a camera (n,) has, and the forms; see `Drawn`."""
    count = projection.corner_points.shape[1]
    which = camera * count + triangles
    used = np.zeros(len(projection.views) * count, dtype=np.bool_)
    used[which] = True
    pairs = used.nonzero()[0]
    place = np.empty(len(used), dtype=np.int64)
    place[pairs] = np.arange(len(pairs))
    own_camera = pairs // count
    own = pairs - own_camera * count
    values = np.take(projection.normals, own, axis=2)
    if projection.surface.shape[1]:
        values = np.concatenate([values, np.take(projection.surface, own, axis=2)], axis=1)
    weights = _inverses(projection.corners(own_camera, own)).astype(np.float32)
    forms = weights[0][:, None] * values[0]
    for i in (1, 2):
        forms += weights[i][:, None] * values[i]
    return place.take(which), np.ascontiguousarray(forms.reshape(3 * values.shape[1], -1).T)


def _inverse_depths(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Factors (3, k) of u, v and 1 that give the inverse depth of triangles with image points (3 corners, 3, k)."""
    a, b = p[1] - p[0], p[2] - p[0]
    plane = np.stack([a[(j + 1) % 3] * b[(j + 2) % 3] - a[(j + 2) % 3] * b[(j + 1) % 3] for j in range(3)])
    determinant = p[0, 0] * plane[0] + p[0, 1] * plane[1] + p[0, 2] * plane[2]
    plane /= np.where(determinant == 0.0, 1.0, determinant)
    return plane


def _inverses(p: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverse (3, 3, k) of matrices whose columns are the image points (3 corners, 3, k) of triangles."""
    rows = np.empty_like(p)
    for i in range(3):
        a, b = p[(i + 1) % 3], p[(i + 2) % 3]
        for j in range(3):
            rows[i, j] = a[(j + 1) % 3] * b[(j + 2) % 3] - a[(j + 2) % 3] * b[(j + 1) % 3]
    determinant = p[0, 0] * rows[0, 0] + p[0, 1] * rows[0, 1] + p[0, 2] * rows[0, 2]
    rows /= np.where(determinant == 0.0, 1.0, determinant)
    return rows
