"""Which triangle each pixel of some cameras sees, and how far away.

All points are projected for all cameras in one go, and the few triangles that face one and hold the middle of a pixel are cut
into spans of pixels, row by row. With P the matrix of the homogeneous image points (u z, v z, z) of its corners, 1/z is
(1, 1, 1) P^-1 (u, v, 1), affine over a triangle, and any quantity q of the corners is q P^-1 (u, v, 1) z: perspective comes out
right. What rests before a camera at rest is drawn once: keys of pixels, which merge by the greatest, are kept in layers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.raster.spans import Projection, Spans, inverses_of_keys, outlines_of, parts_of_keys
from rlbench_pin.sim.render.raster.stage import Layers, Placed

TOUCHING = np.float32(1e-5)
"""So far behind the room objects are still seen [m]."""


_SOLID = np.float32(0.999)
"""From this opacity on nothing is seen through a surface."""


@dataclass(frozen=True, eq=False)
class Sight:
    """A camera, and what hides moving objects from it."""

    view: CameraView
    limit: NDArray[np.float32] | None
    """Depth (h * w,) from which on nothing is seen [m]; nothing hides anything when None."""
    is_lit: bool = False
    """Whether colours are wanted."""
    ambient: float = 1.0
    """Brightness where the key light does not reach, for renderers that light what they draw."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """The pixels of one camera that see a triangle, ascending."""

    pixels: NDArray[np.int64]
    """Flat indices (n,)."""
    triangles: NDArray[np.int64]
    """What they see (n,)."""
    inverse: NDArray[np.float32]
    """Inverse depth (n,) [1/m]."""
    depth: NDArray[np.float32]
    """(n,) [m]."""
    normals: NDArray[np.float32]
    """Unit normals (3, n) in the world, between those of the corners; none where no colours are wanted."""
    surface: NDArray[np.float32]
    """Values of `Parts.surface`, between those of the corners, (c, n); none where no colours are wanted."""
    behind: Drawn | None = None
    """Surfaces behind glass; None where there is none, or no colours are wanted."""


@dataclass(frozen=True, eq=False)
class Blocked:
    """Where moving objects stand in a light, in a part of the image that it takes."""

    row: int
    """First row of the part."""
    column: int
    """Its first column."""
    depth: NDArray[np.float32]
    """Distance along the light to the first object, infinite where there is none, (h, w) [m]."""


def draw(
    placed: Placed, layers: Layers, opacity: NDArray[np.float32], sights: Sequence[Sight], light: CameraView | None
) -> tuple[list[Drawn], Blocked | None]:
    """Draw all triangles as some cameras see them; an image is the same whatever other cameras look, and was drawn before.

    Args:
        placed: The triangles.
        layers: What was drawn before.
        opacity: Of each (m,): 0 is not seen, 1 hides all, what lies between is glass, which casts no shadow.
        sights: The cameras.
        light: Camera of a light.

    Returns:
        What each camera sees, and what stands in the light; None where that is not asked for.
    """
    views = [*(sight.view for sight in sights), *([] if light is None else [light])]
    projection = Projection(placed, views)
    starts = np.cumsum([0, *(view.size[0] * view.size[1] for view in views)])
    used = [slice(0, view.size[0] * view.size[1]) for view in views]
    if light is not None:
        # most of its image is empty
        (_, begin), (_, end) = projection.bounds(len(sights))
        used[-1] = slice(begin * light.size[0], (end + 1) * light.size[0])
    solid, glass = opacity >= _SOLID, (opacity > 0.0) & (opacity < _SOLID)
    nearest = np.empty(int(starts[-1]), dtype=np.int64)
    _draw_into(nearest, starts, projection, solid & _from_layers(nearest, starts, used, projection, placed, layers, solid))
    blocked = None if light is None else _blocked(nearest[starts[len(sights)] :], projection)
    keys = nearest[: starts[len(sights)]]
    if not glass.any():
        return _with_normals(_seen(keys, sights, starts), sights, projection), blocked
    front = keys.copy()
    is_camera = np.arange(len(views)) < len(sights)
    _draw_into(front, starts, projection, glass & is_camera[:, None])
    seen = _with_normals(_seen(front, sights, starts), sights, projection)
    behind = _with_normals(_seen(np.where(front != keys, keys, 0), sights, starts), sights, projection)
    return [replace(own, behind=far) if len(far.pixels) else own for own, far in zip(seen, behind, strict=True)], blocked


def _seen(keys: NDArray[np.int64], sights: Sequence[Sight], starts: NDArray[np.int64]) -> list[tuple[NDArray, ...]]:
    """Of each camera pixels, triangles, inverse depths and depths (n,) of keys that are not 0, before what hides them."""
    pixels = (keys > 0).nonzero()[0]
    triangles, inverse = parts_of_keys(keys.take(pixels))
    depth: NDArray[np.float32] = np.float32(1.0) / inverse
    ends = np.searchsorted(pixels, starts)
    drawn: list[tuple[NDArray, ...]] = []
    for number, sight in enumerate(sights):
        part = slice(ends[number], ends[number + 1])
        flat = pixels[part] - starts[number]
        quantities: tuple[NDArray, ...] = (flat, triangles[part], inverse[part], depth[part])
        if sight.limit is not None:
            seen = quantities[3] < sight.limit.take(flat) + TOUCHING
            if not seen.all():
                quantities = tuple(values[seen] for values in quantities)
        drawn.append(quantities)
    return drawn


def _blocked(nearest: NDArray[np.int64], projection: Projection) -> Blocked:
    """Surfaces in the light, which is the last camera, from the keys (n,) of its pixels."""
    width, height = projection.views[-1].size
    (first, begin), (last, end) = projection.bounds(len(projection.views) - 1)
    part = nearest.reshape(height, width)[begin : end + 1, first : last + 1]
    with np.errstate(divide="ignore"):
        return Blocked(begin, first, np.float32(1.0) / inverses_of_keys(part))


def _from_layers(
    nearest: NDArray[np.int64],
    starts: NDArray[np.int64],
    used: Sequence[slice],
    projection: Projection,
    placed: Placed,
    layers: Layers,
    shown: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Fill the `used` pixels of all images with what cameras at rest see of links at rest.

    Returns:
        What has still to be drawn, (c, m).
    """
    keys = [nearest[start + part.start : start + part.stop] for start, part in zip(starts, used)]
    kept = layers.of(projection.views, shown, placed.still)
    link = placed.parts.link
    missing = np.zeros((len(kept), len(placed.still)), dtype=np.bool_)
    for number, (layer, own) in enumerate(zip(kept, keys, strict=True)):
        if layer is not None:
            missing[number] = placed.still & ~layer.links
        if layer is None or missing[number].any():
            own[:] = 0
    if missing.any():
        _draw_into(nearest, starts, projection, shown & missing.take(link, axis=1))
    left = np.ones((len(kept), len(placed.still)), dtype=np.bool_)
    for number, (layer, own, part) in enumerate(zip(kept, keys, used, strict=True)):
        if layer is None:
            continue
        resting = layer.nearest[part]
        if missing[number].any():
            np.maximum(resting, own, out=resting)
            layer.links[missing[number]] = True
        own[:] = resting
        left[number] = ~layer.links
    return (left & projection.reached).take(link, axis=1)


def _draw_into(nearest: NDArray[np.int64], starts: NDArray[np.int64], projection: Projection, wanted: NDArray[np.bool_]) -> None:
    """Draw the triangles that each camera wants (c, m) into the keys (n,) of the pixels of all cameras."""
    outlines = outlines_of(projection, wanted)
    camera = outlines.camera
    widths, heights = np.array([view.size for view in projection.views]).T
    spans = Spans(outlines, widths.take(camera), heights.take(camera))
    planes = _inverse_depths(projection.corners(camera, outlines.triangle))
    spans.draw_into(nearest, planes, starts.take(camera), widths.take(camera))


def _with_normals(drawn: Sequence[tuple[NDArray, ...]], sights: Sequence[Sight], projection: Projection) -> list[Drawn]:
    """Add what lies between the corners of the triangles that are seen, for cameras that want colours."""
    count = projection.corner_points.shape[1]
    lit = [number for number, sight in enumerate(sights) if sight.is_lit]
    used = np.zeros((len(sights), count), dtype=np.bool_)
    for number in lit:
        used[number, drawn[number][1]] = True
    camera, triangle = np.nonzero(used)
    place = np.empty((len(sights), count), dtype=np.int64)
    place[camera, triangle] = np.arange(len(camera))
    values = np.take(projection.normals, triangle, axis=2)
    if projection.surface.shape[1]:
        values = np.concatenate([values, np.take(projection.surface, triangle, axis=2)], axis=1)
    forms = _forms(_inverses(projection.corners(camera, triangle)), values)
    between = [np.zeros((values.shape[1], 0), dtype=np.float32)] * len(drawn)
    if lit:
        chosen = np.concatenate([place[number].take(drawn[number][1]) for number in lit])
        rows = [drawn[number][0] // sights[number].view.size[0] for number in lit]
        columns = [drawn[number][0] - row * sights[number].view.size[0] for number, row in zip(lit, rows, strict=True)]
        inverse = np.concatenate([drawn[number][2] for number in lit])
        found = _between(forms.take(chosen, axis=0), np.concatenate(rows), np.concatenate(columns), inverse)
        ends = np.cumsum([0, *(len(row) for row in rows)])
        for number, begin, end in zip(lit, ends, ends[1:]):
            between[number] = found[:, begin:end]
    return [
        Drawn(pixels, triangles, inverse, depth, own[:3], own[3:])
        for (pixels, triangles, inverse, depth), own in zip(drawn, between, strict=True)
    ]


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


def _forms(inverses: NDArray[np.float64], values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Factors (k, 3 c) of u, v and 1, c each, that give values over the depth between those of the corners, (3 corners, c, k)."""
    weights = inverses.astype(np.float32)
    forms = weights[0][:, None] * values[0]
    for i in (1, 2):
        forms += weights[i][:, None] * values[i]
    return np.ascontiguousarray(forms.reshape(3 * values.shape[1], -1).T)


def _between(
    forms: NDArray[np.float32], row: NDArray[np.int64], column: NDArray[np.int64], inverse: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Unit vectors and further values (c, n) at pixels in rows and columns (n,), from factors (n, 3 c) and inverse depths."""
    u, v = column.astype(np.float32), row.astype(np.float32)
    count = forms.shape[1] // 3
    result = np.empty((count, len(u)), dtype=np.float32)
    for i, values in enumerate(result):
        np.multiply(forms[:, i], u, out=values)
        values += forms[:, count + i] * v
        values += forms[:, 2 * count + i]
    x, y, z = vectors = result[:3]
    vectors /= np.maximum(np.sqrt(x * x + y * y + z * z), np.float32(1e-12))
    result[3:] /= inverse
    return result
