"""Three directional lights, and the shadow map of the first: one image of the moving objects from the light, for all cameras.

Its texels are 3 mm wide. On the horizontal table a shadow is the smoothed image of the objects above it: the filter is a few
texels wide for low objects, and four times as wide for high ones. A point of a moving object is in shadow by the share of the
texels around it that are nearer to the light. The map also gives the contact shadows on the table: parts of objects low above
the table darken the table around them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.errors import CameraError, InvalidCamera
from rlbench_pin.sim.render.camera import CameraView, pixel_rays
from rlbench_pin.sim.render.raster.drawing import Blocked
from rlbench_pin.spatial import TABLE_HEIGHT, matrix_to_pose
from rlbench_pin.values import as_number, as_vector

Vector = tuple[float, float, float]
SPECULAR = 0.05
"""Brightness of the highlight of the key light."""


@dataclass(frozen=True)
class Light:
    """A directional light, infinitely far away."""

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
            raise CameraError(f"A light needs finite numbers and a direction other than zero. Got {self}.")
        if self.intensity < 0.0 or not all(0.0 <= c <= 1.0 for c in self.color):
            raise CameraError(f"A light needs an intensity >= 0 and a colour in 0..1. Got {self}.")

    @property
    def unit(self) -> NDArray[np.float64]:
        """Unit direction (3,)."""
        vector = np.array(self.direction, dtype=float)
        return vector / np.linalg.norm(vector)

    def on(self, normals: NDArray) -> NDArray:
        """Brightness of surfaces with unit `normals` (..., 3)."""
        return np.maximum(normals @ self.unit.astype(normals.dtype), 0.0) * self.intensity


@dataclass(frozen=True)
class Lighting:
    """All light in a world."""

    key: Light = Light((0.6, 0.4, 1.6), 0.36)
    """The sun of the scene; casts the shadows."""
    fills: tuple[Light, ...] = field(default=(Light((-0.9, 0.8, 0.9), 0.17), Light((0.5, -1.2, 0.5), 0.10)))
    """Soft lights from the other sides."""
    ambient: float = 0.53
    """Brightness of a white surface that no light reaches."""

    def __post_init__(self) -> None:
        if not isinstance(self.fills, tuple | list) or not all(isinstance(light, Light) for light in (self.key, *self.fills)):
            raise CameraError(
                "The key light and the fill lights of a `Lighting` have to be `Light` records. Create them with `Light(...)`."
            )
        as_number(self.ambient, "Lighting.ambient", InvalidCamera)
        if not 0.0 < self.ambient <= 1.0:
            raise CameraError(f"The ambient light has to be above 0 and at most 1. Got {self.ambient}.")

    @property
    def is_white(self) -> bool:
        """Whether no light has a colour."""
        return all(light.color == (1.0, 1.0, 1.0) for light in (self.key, *self.fills))

    @property
    def mean_fill(self) -> float:
        """Mean brightness of the fill lights over all viewing directions."""
        return 0.35 * sum(fill.intensity for fill in self.fills)


_CENTER = np.array([0.15, 0.0, TABLE_HEIGHT + 0.1])
_SIZE, _TEXEL = 512, 0.003
"""Side of the image that the key light takes [px], and of one of its texels at the table [m]."""
_BLOCKS = _SIZE // 4
"""Side of the same in blocks of four by four texels."""
_DISTANCE = 30.0  # far away, so that its rays are almost parallel [m]
_FAR = np.float32(np.inf)
_BORDER, _MARGIN = 4, 24
"""So many texels at the border of the image stay free, and so far a shadow on the table reaches beyond what casts it [px]."""
_TOUCHING = np.float32(0.002)  # so little above the table objects cast no shadow on it; the next heights begin there [m]
_SHARP, _SOFT = 0.02, 0.30
"""Heights of casters above the table up to which their shadows are sharp, and from which on they are soft [m]."""
_LOW, _HIGH = (0.0, 0.012), (0.018, 0.088)
"""Between these heights above the table objects begin to darken it, and cease to [m]."""
_DARKENING = np.float32(1.1)


@lru_cache(maxsize=8)
def light_view(direction: Vector) -> CameraView:
    """Return the camera of a light; its image is aligned with the sides of the table.

    Args:
        direction: `Light.direction`, which points towards the light.
    """
    forward = -np.array(direction) / np.linalg.norm(direction)
    along = np.array([1.0, 0.0, 0.0]) if abs(forward[0]) < 0.9 else np.array([0.0, 0.0, 1.0])
    up = along - along.dot(forward) * forward
    up /= np.linalg.norm(up)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([np.cross(up, forward), up, forward])
    matrix[:3, 3] = _CENTER - _DISTANCE * forward
    fov = 2.0 * float(np.arctan(0.5 * _SIZE * _TEXEL / _DISTANCE))
    return CameraView(pose=matrix_to_pose(matrix), fov=fov, size=(_SIZE, _SIZE), near=_DISTANCE - 2.0, far=_DISTANCE + 2.0)


@dataclass(frozen=True, eq=False)
class LightSpots:
    """Positions of points in the shadow map."""

    right: NDArray[np.float32]
    """Column (n,), the middle of the first at 0.5 [px]."""
    down: NDArray[np.float32]
    """Row (n,) [px]."""
    depth: NDArray[np.float32]
    """Distance along the light (n,) [m]."""


@dataclass(frozen=True, eq=False)
class TableSpots:
    """Positions in the shadow map of the pixels of a camera that show the table."""

    pixels: NDArray[np.int64]
    """Flat indices of the pixels (n,)."""
    right: NDArray[np.float32]
    """Column (n,), the middle of the first texel at 0.5 [px]."""
    down: NDArray[np.float32]
    """Row (n,) [px]."""
    block: NDArray[np.int32]
    """Block of four by four texels (n,)."""
    is_fine: bool
    """Whether some pixels are as small as a texel."""


@dataclass(frozen=True, eq=False)
class TableShade:
    """Share of the key light that is blocked on the table: `soft` plus `sharpness` times `sharp` / 255."""

    sharp: NDArray[np.uint8]
    """Texels that are blocked, smoothed by 5 x 5, (n, n)."""
    sharpness: NDArray[np.float32]
    """How sharp the shadow is, of every four by four texels, 0..1, (n / 4, n / 4)."""
    soft: NDArray[np.float32]
    """Soft part of the shadow, and the darkening at the feet of objects, of every four by four texels (n / 4, n / 4)."""
    dark: NDArray[np.bool_]
    """Of every four by four texels, whether any shadow is there, (n / 4, n / 4)."""

    def copy(self) -> TableShade:
        """Return a copy."""
        return TableShade(self.sharp.copy(), self.sharpness.copy(), self.soft.copy(), self.dark.copy())


class ShadowMap:
    """Shadow map of the key light.

    Args:
        view: Camera of the light.
        height: z of the table top [m].
        blocked: Where moving objects block the light.
        under: The shadows of objects that block the light elsewhere.

    Attributes:
        view: The same.
        height: The same.
        is_empty: Whether no object blocks the light.
        image: Depth of the objects that block the light, per texel; absent without own objects.
        rows: Rows of it that are filled.
    """

    def __init__(self, view: CameraView, height: float, blocked: Blocked, under: ShadowMap | None = None) -> None:
        self.view, self.height = view, height
        self._under = None if under is None or under.is_empty else under
        rows, columns = (
            slice(max(first, _BORDER), min(first + count, _SIZE - _BORDER))
            for first, count in zip((blocked.row, blocked.column), blocked.depth.shape, strict=True)
        )
        self._is_same = rows.start >= rows.stop or columns.start >= columns.stop
        self.is_empty: bool = self._is_same and self._under is None
        if self._is_same:
            return
        self._window = _span(rows), _span(columns)
        # what is not filled is not looked up
        self.image = np.empty((_SIZE, _SIZE), dtype=np.float32)
        self.rows = self._window[0]
        if self._under is None:
            self.image[self.rows] = _FAR
        else:
            others = self._under.rows
            self.rows = slice(min(self.rows.start, others.start), max(self.rows.stop, others.stop))
            self.image[self.rows.start : others.start], self.image[others.stop : self.rows.stop] = _FAR, _FAR
            self.image[others] = self._under.image[others]
        self.image[rows, columns] = blocked.depth[_moved(rows, blocked.row), _moved(columns, blocked.column)]

    def lit(self, spots: LightSpots, bias: NDArray[np.float32]) -> NDArray[np.float32]:
        """Share (n,) of the key light that reaches points of moving objects, 0..1: the unblocked part of the 3 x 3 texels
        around each.

        Most points are behind all texels around them or in front of them all, which two look-ups show.

        Args:
            spots: The points.
            bias: Smallest distance in front of a point at which an object shades it (n,) [m].
        """
        if self._is_same and self._under is not None:
            return self._under.lit(spots, bias)
        column, row = (
            np.minimum(np.maximum(values, np.float32(2.0)), np.float32(_SIZE - 3)).astype(np.int64)
            for values in (spots.right, spots.down)
        )
        block = row >> 2
        block *= _BLOCKS
        block += column >> 2
        limit = spots.depth - bias
        least, greatest = self.extremes
        is_free = least.take(block) >= limit
        share = is_free.astype(np.float32)
        reached = (~is_free).nonzero()[0]
        edge = reached.take((greatest.take(block.take(reached)) >= limit.take(reached)).nonzero()[0])
        share[edge] = self._share(spots.right.take(edge), spots.down.take(edge), limit.take(edge))
        return share

    def _share(self, right: NDArray[np.float32], down: NDArray[np.float32], limit: NDArray[np.float32]) -> NDArray[np.float32]:
        """Unblocked share (k,) of squares of 3 x 3 texels: of 4 x 4 texels the outer ones count in part.

        Args:
            right: Column of the middles of the squares (k,), the middle of the first texel at 0.5; overwritten.
            down: Row (k,); overwritten.
            limit: Smallest depth of an unblocked texel (k,) [m].
        """
        first = np.zeros(len(limit), dtype=np.int64)
        for values, step in ((down, _SIZE), (right, 1)):
            values -= np.float32(1.5)
            np.maximum(values, np.float32(0.0), out=values)
            np.minimum(values, np.float32(_SIZE - 4), out=values)
            whole = values.astype(np.int64)
            values -= whole
            first += whole * step
        depth = self.image.ravel()
        is_free = np.empty((4, 4, len(first)), dtype=np.bool_)
        for row in range(4):
            for column in range(4):
                np.greater_equal(depth[row * _SIZE + column :][first], limit, out=is_free[row, column])
        free = is_free.view(np.int8)
        # summed over rows and columns, a + b x + c y + d x y
        level, slope = free[0] + free[1] + free[2], free[3] - free[0]
        share = (slope[3] - slope[0]) * right
        share += slope[0] + slope[1] + slope[2]
        share *= down
        share += (level[3] - level[0]) * right
        share += level[0] + level[1] + level[2]
        share *= np.float32(1.0 / 9.0)
        return share

    @cached_property
    def extremes(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Minimum and maximum of every block of four by four texels and its neighbours, flat."""
        rows, columns = (slice(part.start // 4 + 1, part.stop // 4 - 1) for part in self._window)
        image = self.image[self._window]
        found = []
        for number, function in enumerate((np.minimum, np.maximum)):
            blocks = function(function(image[0::4], image[1::4]), function(image[2::4], image[3::4]))
            blocks = function(function(blocks[:, 0::4], blocks[:, 1::4]), function(blocks[:, 2::4], blocks[:, 3::4]))
            full = np.full((_BLOCKS, _BLOCKS), _FAR) if self._under is None else self._under.extremes[number].copy()
            full = full.reshape(_BLOCKS, _BLOCKS)
            across = function(function(blocks[:, :-2], blocks[:, 2:]), blocks[:, 1:-1])
            function(function(across[:-2], across[2:]), across[1:-1], out=full[rows, columns])
            found.append(full.ravel())
        return found[0], found[1]

    @cached_property
    def shade(self) -> TableShade:
        """Two filters: one of 5 x 5 texels for low objects, one four times as wide for high ones; blended by the mean height of
        the objects that cast the shadow.
        """
        if self._under is not None and self._is_same:
            return self._under.shade
        limit, image = table_distance(self.view, self.height)[self._window], self.image[self._window]
        blocked = (image < limit).view(np.uint8)
        above = limit[0::2, 0::2] - image[0::2, 0::2]
        np.maximum(above, np.float32(0.0), out=above)
        count = _by_two(_by_two(blocked))
        fields = np.empty((3, *count.shape), dtype=np.float32)
        fields[0] = count
        fields[1] = _by_two(above)
        np.add(_lowness(above[0::2, 0::2], self.view), _lowness(above[1::2, 0::2], self.view), out=fields[2])
        soft, lifted, contact = _smooth(fields)
        # four of sixteen texels have a height
        lifted /= np.maximum(soft, np.float32(1e-6))
        lifted *= np.float32(4.0 / (_SOFT - _SHARP))
        lifted -= np.float32(_SHARP / (_SOFT - _SHARP))
        softness = np.minimum(np.maximum(lifted, np.float32(0.0), out=lifted), np.float32(1.0), out=lifted)
        soft *= softness
        soft *= np.float32(1.0 / (16.0 * 256.0))
        contact *= np.float32(0.5 / 256.0) * _DARKENING
        soft += contact
        dark = soft > np.float32(0.003)
        dark |= count[2:-2, 2:-2] > 0
        shade = _no_shade() if self._under is None else self._under.shade.copy()
        texels = tuple(slice(part.start + 2, part.stop - 2) for part in self._window)
        blocks = tuple(slice(part.start // 4 + 2, part.stop // 4 - 2) for part in self._window)
        shade.sharp[texels] = _smooth_bytes(blocked)
        np.subtract(np.float32(1.0), softness, out=shade.sharpness[blocks])
        shade.soft[blocks], shade.dark[blocks] = soft, dark
        return shade

    def at(
        self, spots: Sequence[TableSpots], again: Sequence[NDArray[np.bool_] | None]
    ) -> tuple[list[NDArray[np.int64]], NDArray[np.float32]]:
        """Return which pixels that see the table may be darker, of each camera, and how much of the key light these miss (k,).

        Args:
            spots: The table as each camera sees it.
            again: Of every block whether to look there, flat, for each camera; at all that may be darker when None. Blocks that
                may be darker without what moves count too.
        """
        shade = self.shade
        reached = spread(shade.dark).ravel()
        there = reached if self._under is None else reached | spread(self._under.shade.dark).ravel()
        chosen = [
            (reached if wanted is None else there & wanted).take(each.block).nonzero()[0]
            for each, wanted in zip(spots, again, strict=True)
        ]
        right, down, block = (
            np.concatenate([getattr(each, name).take(points) for each, points in zip(spots, chosen, strict=True)])
            for name in ("right", "down", "block")
        )
        place = down.astype(np.int64) * _SIZE
        place += right.astype(np.int64)
        sharp = shade.sharp.take(place).astype(np.float32)
        ends = np.cumsum([0, *(len(points) for points in chosen)])
        for each, begin, end in zip(spots, ends, ends[1:]):
            if each.is_fine:
                own = slice(begin, end)
                (sharp[own],) = _between([shade.sharp], right[own] - np.float32(0.5), down[own] - np.float32(0.5))
        for values in (right, down):
            values -= np.float32(2.0)
            values *= np.float32(0.25)
        sharpness, missing = _between([shade.sharpness, shade.soft], right, down)
        sharp *= sharpness
        sharp *= np.float32(1.0 / 255.0)
        missing += sharp
        if there is not reached:
            missing *= reached.take(block)
        return [each.pixels.take(points) for each, points in zip(spots, chosen, strict=True)], missing


def _no_shade() -> TableShade:
    fields = np.zeros((2, _BLOCKS, _BLOCKS), dtype=np.float32)
    return TableShade(np.zeros((_SIZE, _SIZE), np.uint8), fields[0], fields[1], np.zeros((_BLOCKS, _BLOCKS), dtype=np.bool_))


def spread(blocks: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """These blocks (n, m) and those around them."""
    rows = blocks.copy()
    rows[1:] |= blocks[:-1]
    rows[:-1] |= blocks[1:]
    result = rows.copy()
    result[:, 1:] |= rows[:, :-1]
    result[:, :-1] |= rows[:, 1:]
    return result


def _between(fields: Sequence[NDArray], x: NDArray[np.float32], y: NDArray[np.float32]) -> list[NDArray[np.float32]]:
    """Values (k,) of fields (n, m) at columns x and rows y (k,), between those of four cells."""
    column, row = x.astype(np.int64), y.astype(np.int64)
    right, down = (values - whole.astype(np.float32) for values, whole in ((x, column), (y, row)))
    width = fields[0].shape[1]
    row *= width
    row += column
    found = []
    for values in fields:
        corners = [values.take(row + step).astype(np.float32, copy=False) for step in (0, 1, width, width + 1)]
        for first, second in (corners[:2], corners[2:]):
            second -= first
            second *= right
            first += second
        upper, lower = corners[0], corners[2]
        lower -= upper
        lower *= down
        upper += lower
        found.append(upper)
    return found


@lru_cache(maxsize=4)
def table_distance(view: CameraView, height: float) -> NDArray[np.float32]:
    """Return the distance (n, n) along the light up to which objects cast a shadow on the table [m].

    Args:
        view: Camera of the light.
        height: z of the table top [m].
    """
    (columns, rows), turn = pixel_rays(view), view.extrinsics()[2, :3]
    rays = ((turn[0] * columns)[None, :] + (turn[1] * rows + turn[2])[:, None]).astype(np.float32)
    return (np.float32(height - view.pose[2]) / np.minimum(rays, np.float32(-1e-3)) - _TOUCHING).astype(np.float32)


def _lowness(above: NDArray[np.float32], view: CameraView) -> NDArray[np.float32]:
    """How much light objects keep from the table around them (n, m), 0..1, by how far above it they are along the light [m]."""
    cosine = float(-view.extrinsics()[2, 2])
    begins, ceases = (np.float32(cosine / (span[1] - span[0])) for span in (_LOW, _HIGH))
    share = np.minimum(above * begins - np.float32(_LOW[0] / (_LOW[1] - _LOW[0])), np.float32(1.0))
    np.minimum(share, np.float32(_HIGH[1] / (_HIGH[1] - _HIGH[0])) - above * ceases, out=share)
    return np.maximum(share, np.float32(0.0), out=share)


def _smooth(fields: NDArray[np.float32]) -> NDArray[np.float32]:
    """Sums (c, n - 4, m - 4) of five by five of fields (c, n, m), weighted by 1, 4, 6, 4 and 1 both ways."""
    for _ in range(4):
        fields = fields[:, :-1] + fields[:, 1:]
    for _ in range(4):
        fields = fields[:, :, :-1] + fields[:, :, 1:]
    return fields


def _smooth_bytes(values: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The same sums (n - 4, m - 4) of values 0 and 1 (n, m), 255 in place of 256."""
    for _ in range(4):
        values = values[:-1] + values[1:]
    for _ in range(3):
        values = values[:, :-1] + values[:, 1:]
    result = values[:, 1:] - (values[:, 1:] >> 7)
    result += values[:, :-1]
    return result


def _by_two(values: NDArray) -> NDArray:
    """Sums (n / 2, m / 2) of two by two."""
    rows = values[0::2] + values[1::2]
    result: NDArray = rows[:, 0::2] + rows[:, 1::2]
    return result


def _span(own: slice) -> slice:
    """Texels and a margin, a multiple of four."""
    return slice(max(own.start - _MARGIN, 0) & ~3, min(own.stop + _MARGIN + 3, _SIZE) & ~3)


def _moved(own: slice, start: int) -> slice:
    """The same texels, counted from another one."""
    return slice(own.start - start, own.stop - start)


def to_light(light: CameraView, view: CameraView) -> NDArray[np.float32]:
    """Matrix (3, 4) from u z, v z, z and 1 in the image of a camera to the same in that of a light."""
    result = light.to_image[:, :3] @ view.from_image
    result[:, 3] += light.to_image[:, 3]
    return result.astype(np.float32)


def table_spots(light: CameraView, view: CameraView, height: float, pixels: NDArray[np.int64]) -> TableSpots:
    """Find the pixels of a camera that see the table in the image that `light` takes.

    Args:
        light: Camera of the light.
        view: The camera.
        height: z of the table top [m].
        pixels: Flat indices of the pixels that see the table (n,).
    """
    # a pixel with ray d sees the point eye + d (height - eye_z) / d_z: times d_z, all is linear in (u, v, 1)
    rays, eye = view.from_image[:, :3], view.from_image[:, 3]
    up = height - eye[2]
    forms = light.to_image[:, :3] @ (np.outer(eye, rays[2]) + up * rays) + np.outer(light.to_image[:, 3], rays[2])
    columns, rows = np.arange(view.size[0]), np.arange(view.size[1])
    every = len(pixels) == len(rows) * len(columns)
    found = []
    for form in forms:
        values = ((form[1] * rows + form[2]).astype(np.float32)[:, None] + (form[0] * columns).astype(np.float32)).ravel()
        found.append(values if every else values.take(pixels))
    right, down, along = found
    for values in (right, down):
        values /= along
        values += np.float32(0.5)
        np.maximum(values, np.float32(1.0), out=values)
        np.minimum(values, np.float32(_SIZE - 1.501), out=values)
    block = down.astype(np.int32) >> 2
    block *= np.int32(_SIZE // 4)
    block += right.astype(np.int32) >> 2
    steepest = min(rays[2] @ [u, v, 1.0] for u in (0, view.size[0]) for v in (0, view.size[1]))
    return TableSpots(pixels, right, down, block, bool(up >= -_TEXEL * view.intrinsics()[0, 0] * steepest))
