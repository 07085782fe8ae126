"""Three directional lights, and the shadows of the first: one image of the moving objects from the light, for all cameras.

Its texels are 3 mm wide. On the table, which is level, a shadow is the image of what lies above it, smoothed: as wide as a few
texels below low objects, four times as wide below high ones. Points of moving objects are in shadow as far as texels around them
are nearer to the light. The same image says where objects stand on the table: what of them is seen low above it keeps light from
around their feet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.errors import CameraError, InvalidCamera
from rlbench_pin.sim.render.camera import CameraView
from rlbench_pin.sim.render.raster.drawing import Blocked
from rlbench_pin.spatial import TABLE_HEIGHT, matrix_to_pose
from rlbench_pin.values import as_number, as_vector

Vector = tuple[float, float, float]
SPECULAR = 0.05
"""Brightness of the highlight of the key light."""


@dataclass(frozen=True)
class Light:
    """A light that is infinitely far away."""

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
            raise CameraError(f"A light needs a direction other than zero and finite numbers, not {self}.")
        if self.intensity < 0.0 or not all(0.0 <= c <= 1.0 for c in self.color):
            raise CameraError(f"A light has an intensity >= 0 and a colour in 0..1, not {self}.")

    @property
    def unit(self) -> NDArray[np.float64]:
        """Direction (3,) of length one."""
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
            raise CameraError("The key light and the fills of a `Lighting` are `Light`s.")
        as_number(self.ambient, "Lighting.ambient", InvalidCamera)
        if not 0.0 < self.ambient <= 1.0:
            raise CameraError(f"The ambient light lies above 0 and at most at 1, not at {self.ambient}.")

    @property
    def is_white(self) -> bool:
        """Whether no light has a colour."""
        return all(light.color == (1.0, 1.0, 1.0) for light in (self.key, *self.fills))

    @property
    def mean_fill(self) -> float:
        """Mean brightness of the fill lights over all directions that objects are seen from."""
        return 0.35 * sum(fill.intensity for fill in self.fills)


_CENTER = np.array([0.15, 0.0, TABLE_HEIGHT + 0.1])
_SIZE, _TEXEL = 512, 0.003
"""Side of the image that the key light takes [px], and of one of its texels at the table [m]."""
_DISTANCE = 30.0  # far away, so that its rays are almost parallel [m]
_FAR = np.float32(np.inf)
_BORDER, _MARGIN = 4, 24
"""So many texels at the border of the image stay free, and so far a shadow on the table reaches beyond what casts it [px]."""
_TOUCHING = np.float32(0.002)  # so little above the table objects cast no shadow on it [m]
_ON_TABLE = np.float32(0.001)  # so near the table top points count as its own [m]
_SHARP, _SOFT = 0.02, 0.30
"""Heights of casters above the table up to which their shadows are sharp, and from which on they are soft [m]."""
_LOW, _HIGH = (0.002, 0.014), (0.02, 0.09)
"""Between these heights above the table objects begin to darken it, and cease to [m]."""
_DARKENING = np.float32(1.1)
_TAPS = tuple((row, column) for row in range(-2, 3) for column in range(-2, 3) if (row + column) % 2 == 0)
"""Every other texel of 5 x 5."""


def light_view(light: Light) -> CameraView:
    """The camera that sees what the light reaches; its image lies along the sides of the table."""
    forward = -light.unit
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
    """Where points lie in the image that the key light takes."""

    right: NDArray[np.float32]
    """Column (n,), the middle of the first at 0.5 [px]."""
    down: NDArray[np.float32]
    """Row (n,) [px]."""
    depth: NDArray[np.float32]
    """Distance along the light (n,) [m]."""


@dataclass(frozen=True, eq=False)
class TableSpots:
    """Where the pixels of a camera that see the table lie in the image that the key light takes."""

    pixels: NDArray[np.int64]
    """Flat indices of the pixels (n,)."""
    texel: NDArray[np.int64]
    """Texel (n,)."""
    right: NDArray[np.float32] | None
    """How far to the right of its middle (n,) [px]; None where no pixel is as small as a texel."""
    down: NDArray[np.float32] | None
    """How far below its middle (n,) [px]; None where no pixel is as small as a texel."""


class ShadowMap:
    """How far the key light gets.

    Args:
        view: Camera of the light.
        height: z of the table top [m].
        blocked: Where moving objects stand in the light.

    Attributes:
        view: The same.
        is_empty: Whether nothing stands in the light.
    """

    def __init__(self, view: CameraView, height: float, blocked: Blocked) -> None:
        self.view, self._height = view, height
        rows, columns = (
            slice(max(first, _BORDER), min(first + count, _SIZE - _BORDER))
            for first, count in zip((blocked.row, blocked.column), blocked.depth.shape, strict=True)
        )
        self.is_empty = rows.start >= rows.stop or columns.start >= columns.stop
        if self.is_empty:
            return
        self._rows, self._columns = _span(rows), _span(columns)
        self._image = np.full((self._rows.stop - self._rows.start, self._columns.stop - self._columns.start), _FAR, np.float32)
        part = blocked.depth[_moved(rows, blocked.row), _moved(columns, blocked.column)]
        self._image[_moved(rows, self._rows.start), _moved(columns, self._columns.start)] = part

    def lit(self, spots: LightSpots, bias: NDArray[np.float32]) -> NDArray[np.float32]:
        """Share (n,) of the key light that reaches points of moving objects, 0..1: how many of 13 texels around it passes.

        Most points lie beyond all of 5 x 5 texels or before them all, which two look-ups show.

        Args:
            spots: The points, from `spots_of`.
            bias: By how much an object must be nearer to the light to shade a point (n,) [m].
        """
        height, width = self._image.shape
        column, row = spots.right - np.float32(self._columns.start), spots.down - np.float32(self._rows.start)
        for values, side in ((column, width), (row, height)):
            np.maximum(values, np.float32(2.0), out=values)
            np.minimum(values, np.float32(side - 3), out=values)
        down, right = row.astype(np.int64), column.astype(np.int64)
        block = down >> 2
        block *= width >> 2
        block += right >> 2
        limit = spots.depth - bias
        least, greatest = self._extremes
        is_free = least.take(block) >= limit
        share = is_free.astype(np.float32)
        reached = (~is_free).nonzero()[0]
        edge = reached.take((greatest.take(block.take(reached)) >= limit.take(reached)).nonzero()[0])
        share[edge] = self._share(down.take(edge) * width + right.take(edge), limit.take(edge))
        return share

    def _share(self, texel: NDArray[np.int64], limit: NDArray[np.float32]) -> NDArray[np.float32]:
        depth, width = self._image.ravel(), self._image.shape[1]
        free = np.zeros(len(texel), dtype=np.uint8)
        for row, column in _TAPS:
            free += depth.take(texel + (row * width + column)) >= limit
        return free * np.float32(1.0 / len(_TAPS))

    @cached_property
    def _extremes(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Of every four by four texels of the window, flat, the least and the greatest of these and those around them."""
        found = []
        for function in (np.minimum, np.maximum):
            blocks = function(function(self._image[0::4], self._image[1::4]), function(self._image[2::4], self._image[3::4]))
            blocks = function(function(blocks[:, 0::4], blocks[:, 1::4]), function(blocks[:, 2::4], blocks[:, 3::4]))
            full = np.full_like(blocks, _FAR)
            across = function(function(blocks[:, :-2], blocks[:, 2:]), blocks[:, 1:-1])
            function(function(across[:-2], across[2:]), across[1:-1], out=full[1:-1, 1:-1])
            found.append(full.ravel())
        return found[0], found[1]

    @cached_property
    def on_table(self) -> NDArray[np.float32]:
        """How much of the key light the table misses at each texel (n * n,): 1 in full shadow, more at the feet of objects.

        Two filters: one of 5 x 5 texels for what is low above the table, one four times as wide for what is high; between them by
        the mean height of what casts the shadow.
        """
        result = np.zeros((_SIZE, _SIZE), dtype=np.float32)
        if self.is_empty:
            return result.ravel()
        height = ground_distance(self.view, self._height)[self._rows, self._columns] - self._image
        blocked = height > _TOUCHING
        np.maximum(height, np.float32(0.0), out=height)
        lowness = _lowness(height[0::4, 0::4], self.view)
        lowness += _lowness(height[2::4, 2::4], self.view)
        sums = (_by_four(blocked.view(np.uint8)).astype(np.float32), _by_four(height), lowness)
        coarse, lifted, contact = (_smooth(_smooth(values).T).T for values in sums)
        lifted /= np.maximum(coarse, np.float32(1e-6))
        lifted -= np.float32(_SHARP)
        lifted *= np.float32(1.0 / (_SOFT - _SHARP))
        softness = np.minimum(np.maximum(lifted, np.float32(0.0), out=lifted), np.float32(1.0), out=lifted)
        coarse *= softness
        coarse *= np.float32(1.0 / (16.0 * 256.0))
        contact *= np.float32(0.5 / 256.0) * _DARKENING
        coarse += contact
        # 3 x 3 before and after both are put together make 5 x 5, and no steps are seen of the coarse one
        fine = _smooth(_smooth(blocked.view(np.uint8)[7:-7, 7:-7], 2).T, 2).T.astype(np.float32, order="C")
        pairs = fine.reshape(len(fine) // 2, 2, -1)
        pairs *= _four_times((np.float32(1.0) - softness) * np.float32(1.0 / 256.0))
        pairs += _four_times(coarse * np.float32(1.0 / 16.0))
        fine = _smooth(_smooth(fine, 2).T, 2).T
        result[self._rows.start + 9 : self._rows.stop - 9, self._columns.start + 9 : self._columns.stop - 9] = fine
        return result.ravel()

    def at(self, spots: Sequence[TableSpots]) -> tuple[list[NDArray[np.int64]], NDArray[np.float32]]:
        """Return which points of the table are darker, of each of some cameras, and how much of the key light these miss (k,)."""
        values = self.on_table
        found = [values.take(each.texel) for each in spots]
        chosen = [(each > np.float32(0.004)).nonzero()[0] for each in found]
        missing = [each.take(points) for each, points in zip(found, chosen, strict=True)]
        fine = [n for n, each in enumerate(spots) if each.right is not None]
        if fine:
            texel = np.concatenate([spots[n].texel.take(chosen[n]) for n in fine])
            total = np.concatenate([missing[n] for n in fine])
            for name, step in (("right", 1), ("down", _SIZE)):
                slope = values.take(texel + step)
                slope -= values.take(texel - step)
                slope *= np.concatenate([getattr(spots[n], name).take(chosen[n]) for n in fine])
                slope *= np.float32(0.5)
                total += slope
            for n, part in zip(fine, np.split(total, np.cumsum([len(missing[n]) for n in fine])[:-1]), strict=True):
                missing[n] = part
        return chosen, np.concatenate(missing)


@lru_cache(maxsize=4)
def ground_distance(view: CameraView, height: float) -> NDArray[np.float32]:
    """Distance (n, n) along the light to a level plane [m].

    Args:
        view: Camera of the light.
        height: z of the plane [m].
    """
    rays = view.rays[:, 2].reshape(_SIZE, _SIZE)
    return (np.float32(height - view.pose[2]) / np.minimum(rays, np.float32(-1e-3))).astype(np.float32)


def _lowness(above: NDArray[np.float32], view: CameraView) -> NDArray[np.float32]:
    """How much light objects keep from the table around them (n, m), 0..1, by how far above it they are along the light [m]."""
    cosine = float(-view.extrinsics()[2, 2])
    begins, ceases = (np.float32(cosine / (span[1] - span[0])) for span in (_LOW, _HIGH))
    share = np.minimum(above * begins - np.float32(_LOW[0] / (_LOW[1] - _LOW[0])), np.float32(1.0))
    np.minimum(share, np.float32(_HIGH[1] / (_HIGH[1] - _HIGH[0])) - above * ceases, out=share)
    return np.maximum(share, np.float32(0.0), out=share)


def _smooth(values: NDArray, times: int = 4) -> NDArray:
    """Sums (n - times, m) of rows of (n, m), weighted by 1, 2 and 1, or by 1, 4, 6, 4 and 1."""
    for _ in range(times):
        values = values[:-1] + values[1:]
    return values


def _by_four(values: NDArray) -> NDArray:
    """Sums (n / 4, m / 4) of four by four."""
    rows = values[0::4] + values[1::4]
    rows += values[2::4]
    rows += values[3::4]
    result = rows[:, 0::4] + rows[:, 1::4]
    result += rows[:, 2::4]
    result += rows[:, 3::4]
    return result


def _four_times(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Pairs of rows (2 n, 1, 4 m) for each of (n, m): twice as fine with values between them, then each column twice."""
    rows = np.repeat(values * np.float32(0.75), 2, axis=0)
    quarter = values * np.float32(0.25)
    rows[2::2] += quarter[:-1]
    rows[1:-1:2] += quarter[1:]
    own, quarter = rows * np.float32(0.75), rows * np.float32(0.25)
    left, right = own, own.copy()
    left[:, 1:] += quarter[:, :-1]
    right[:, :-1] += quarter[:, 1:]
    result = np.empty((len(rows), 1, 4 * rows.shape[1]), dtype=np.float32)
    for start, part in enumerate((left, left, right, right)):
        result[:, 0, start::4] = part
    return result


def _span(own: slice) -> slice:
    """Texels and a margin, a multiple of four."""
    return slice(max(own.start - _MARGIN, 0) & ~3, min(own.stop + _MARGIN + 3, _SIZE) & ~3)


def _moved(own: slice, start: int) -> slice:
    """The same texels, counted from another one."""
    return slice(own.start - start, own.stop - start)


def spots_of(light: CameraView, view: CameraView, points: NDArray[np.float32]) -> LightSpots:
    """Find points (3, n) [m] in the frame of a camera in the image that `light` takes."""
    x, y, z = points
    found = []
    for a, b, c, shift in (light.to_image @ view.extrinsics()).astype(np.float32):
        value = x * a
        value += y * b
        value += z * c
        value += shift
        found.append(value)
    right, down, depth = found
    for values in (right, down):
        values /= depth
        values += np.float32(0.5)
    return LightSpots(right, down, depth)


def joined_spots(spots: Sequence[LightSpots]) -> LightSpots:
    """Return some spots after each other."""
    return LightSpots(*(np.concatenate([getattr(s, name) for s in spots]) for name in ("right", "down", "depth")))


def table_spots(light: CameraView, view: CameraView, depth: NDArray[np.float32], pixels: NDArray[np.int64]) -> TableSpots:
    """Find the pixels of a camera that see the table in the image that `light` takes.

    Args:
        light: Camera of the light.
        view: The camera.
        depth: What it sees of the room, (h, w) [m].
        pixels: Flat indices of the pixels that see the table (n,).
    """
    row = pixels // view.size[0]
    column = (pixels - row * view.size[0]).astype(np.float32)
    k = view.intrinsics().astype(np.float32)
    z = depth.ravel().take(pixels)
    points = np.empty((3, len(pixels)), dtype=np.float32)
    np.multiply(column - k[0, 2], z / k[0, 0], out=points[0])
    np.multiply(row.astype(np.float32) - k[1, 2], z / k[1, 1], out=points[1])
    points[2] = z
    spots = spots_of(light, view, points)
    right, down = spots.right, spots.down
    for values in (right, down):
        np.maximum(values, np.float32(1.0), out=values)
        np.minimum(values, np.float32(_SIZE - 1.501), out=values)
    texel = down.astype(np.int64) * _SIZE
    texel += right.astype(np.int64)
    if not len(z) or float(z.min()) > -_TEXEL * float(k[0, 0]):
        return TableSpots(pixels, texel, None, None)
    return TableSpots(pixels, texel, right - np.floor(right) - np.float32(0.5), down - np.floor(down) - np.float32(0.5))
