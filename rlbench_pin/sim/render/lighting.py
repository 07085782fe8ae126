"""Three directional lights, and the shadows of the first: one image of the moving objects from the light, for all cameras.

A point is in shadow as far as texels around its place are nearer to the light: a square of 2 x 2, of which each of 3 x 3 counts
by what of it lies there. Most points lie beyond all of these texels or before them all, which two looks tell; only those
at edges are looked at nine times. The same image says where objects stand on the table: what of them is seen low above it
keeps light from around their feet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.errors import CameraError, InvalidCamera
from rlbench_pin.sim.render.camera import CameraView, pixel_rays
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

    key: Light = Light((0.6, 0.4, 1.6), 0.42)
    """The sun of the scene; casts the shadows."""
    fills: tuple[Light, ...] = field(default=(Light((-0.9, 0.8, 0.9), 0.10), Light((0.5, -1.2, 0.5), 0.10)))
    """Soft lights from the other sides."""
    ambient: float = 0.50
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
_REACH = 0.84  # half a side of the square around the centre whose shadows are drawn [m]
_DISTANCE = 30.0  # far away, so that its rays are almost parallel [m]
_SIZE = 256
_ROOM_BIAS = 0.002  # [m]
_FAR = np.float32(np.inf)
_MARGIN = 8  # texels that a shadow, or what objects keep from the table, reaches beyond them
_LOW, _HIGH = (0.002, 0.014), (0.02, 0.09)
"""Between these heights above the table objects begin to darken it, and cease to [m]."""
_DARKENING = np.float32(0.45)
_ON_TABLE = np.float32(0.01)  # so near the table top points count as its own [m]
_STEPS = tuple(tuple(row * _SIZE + column for column in range(-1, 2)) for row in range(-1, 2))


def light_view(light: Light) -> CameraView:
    """The camera that sees what the light reaches; its image lies along the sides of the table."""
    forward = -light.unit
    along = np.array([1.0, 0.0, 0.0]) if abs(forward[0]) < 0.9 else np.array([0.0, 0.0, 1.0])
    up = along - along.dot(forward) * forward
    up /= np.linalg.norm(up)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([np.cross(up, forward), up, forward])
    matrix[:3, 3] = _CENTER - _DISTANCE * forward
    fov = 2.0 * float(np.arctan(_REACH / _DISTANCE))
    return CameraView(pose=matrix_to_pose(matrix), fov=fov, size=(_SIZE, _SIZE), near=_DISTANCE - 2.0, far=_DISTANCE + 2.0)


@dataclass(frozen=True, eq=False)
class LightSpots:
    """Places of points in a shadow map: texel, place in it, and distance from the light."""

    texel: NDArray[np.int64]
    """Texel (n,)."""
    right: NDArray[np.float32]
    """Share (n,) of it that lies to the left."""
    down: NDArray[np.float32]
    """Share (n,) of it that lies above."""
    depth: NDArray[np.float32]
    """Distance along the light (n,) [m]."""

    def at(self, chosen: NDArray[np.int64]) -> LightSpots:
        """Return some of them."""
        return LightSpots(self.texel.take(chosen), self.right.take(chosen), self.down.take(chosen), self.depth.take(chosen))


def joined_spots(spots: Sequence[LightSpots]) -> LightSpots:
    """Return some spots after each other."""
    return LightSpots(*(np.concatenate([getattr(s, name) for s in spots]) for name in ("texel", "right", "down", "depth")))


class ShadowMap:
    """How far the key light gets.

    Args:
        view: Camera of the light.
        depth: Distance (n, n) along the light to the first moving object [m], infinite where there is none; changed here.

    Attributes:
        is_empty: Whether nothing stands in the light.
    """

    def __init__(self, view: CameraView, depth: NDArray[np.float32]) -> None:
        for edge in (depth[:2], depth[-2:], depth[:, :2], depth[:, -2:]):
            edge[:] = _FAR
        self.view, self._image, self._depth = view, depth, depth.ravel()
        self._window = _window_of(depth < _FAR)
        self.is_empty = self._window is None
        self._least, self._greatest = (np.full((_SIZE, _SIZE), _FAR, dtype=np.float32) for _ in range(2))
        if self._window is not None:
            rows, columns = self._window
            seen = depth[rows, columns]
            inner = slice(rows.start + 1, rows.stop - 1), slice(columns.start + 1, columns.stop - 1)
            self._least[inner], self._greatest[inner] = _of_neighbours(np.minimum, seen), _of_neighbours(np.maximum, seen)

    @cached_property
    def is_near(self) -> NDArray[np.bool_]:
        """Of every texel (n * n,), whether one of those around it is blocked."""
        return (self._least < _FAR).ravel()

    @cached_property
    def is_dim(self) -> NDArray[np.bool_]:
        """Of every texel (n * n,), whether objects keep light from the table there."""
        return (self._contact > 0.0).ravel()

    @cached_property
    def _contact(self) -> NDArray[np.float32]:
        """How much of the light from all sides objects keep from the table (n, n), 0..1."""
        result = np.zeros((_SIZE, _SIZE), dtype=np.float32)
        if self._window is not None:
            ground, image = _ground(self.view)[self._window], self._image[self._window]
            # two of four texels, as the corners of a chequered pattern
            coarse = _lowness(ground[0::2, 0::2] - image[0::2, 0::2], self.view)
            coarse += _lowness(ground[1::2, 1::2] - image[1::2, 1::2], self.view)
            coarse *= np.float32(0.5 / 16.0**2) * _DARKENING
            rows, columns = self._window
            inner = slice(rows.start + 4, rows.stop - 4), slice(columns.start + 4, columns.stop - 4)
            result[inner] = _twice_as_fine(_twice_as_fine(_smooth(_smooth(coarse).T)).T)
        return result

    def open(self, spots: LightSpots) -> NDArray[np.float32]:
        """Share (n,) of the light from all sides that reaches points of the room, 0..1: less around what stands on the table."""
        contact = self._contact.ravel()
        value = contact.take(spots.texel)
        for place, step in ((spots.right, 1), (spots.down, _SIZE)):
            slope = contact.take(spots.texel + step) - contact.take(spots.texel - step)
            slope *= np.float32(0.5) * place - np.float32(0.25)
            value += slope
        value *= np.abs(_ground(self.view).ravel().take(spots.texel) - spots.depth) < _ON_TABLE
        return np.subtract(np.float32(1.0), value, out=value)

    def lit(self, spots: LightSpots, bias: NDArray[np.float32] | float = _ROOM_BIAS) -> NDArray[np.float32]:
        """Share (n,) of the key light that reaches points, 0..1.

        Args:
            spots: The points, from `spots_of`.
            bias: By how much an object must be nearer to the light to shade a point [m].
        """
        limit = spots.depth - np.float32(bias)
        share = (self._least.ravel().take(spots.texel) >= limit).astype(np.float32)
        reached = (share == 0.0).nonzero()[0]
        edge = reached.take((self._greatest.ravel().take(spots.texel.take(reached)) >= limit.take(reached)).nonzero()[0])
        share[edge] = self._share(spots.at(edge), limit.take(edge))
        return share

    def _share(self, spots: LightSpots, limit: NDArray[np.float32]) -> NDArray[np.float32]:
        """Mean of 2 x 2 texels around points."""
        total = np.zeros(len(spots.texel), dtype=np.float32)
        for row, weight in zip(_STEPS, (np.float32(1.0) - spots.down, None, spots.down), strict=True):
            free = [(self._depth.take(spots.texel + step) >= limit).astype(np.float32) for step in row]
            part = free[2] - free[0]
            part *= spots.right
            part += free[0]
            part += free[1]
            if weight is not None:
                part *= weight
            total += part
        total *= np.float32(0.25)
        return total


@lru_cache(maxsize=4)
def _ground(view: CameraView) -> NDArray[np.float32]:
    """Distance (n, n) along the light to the plane of the table top [m]."""
    rays = view.rays[:, 2].reshape(_SIZE, _SIZE)
    return (np.float32(TABLE_HEIGHT - view.pose[2]) / np.minimum(rays, np.float32(-1e-3))).astype(np.float32)


def _lowness(above: NDArray[np.float32], view: CameraView) -> NDArray[np.float32]:
    """How much light objects keep from the table around them (n, m), 0..1, by how far above it they are along the light [m]."""
    cosine = float(-view.extrinsics()[2, 2])
    begins, ceases = (np.float32(cosine / (span[1] - span[0])) for span in (_LOW, _HIGH))
    share = np.minimum(above * begins - np.float32(_LOW[0] / (_LOW[1] - _LOW[0])), np.float32(1.0))
    np.minimum(share, np.float32(_HIGH[1] / (_HIGH[1] - _HIGH[0])) - above * ceases, out=share)
    return np.maximum(share, np.float32(0.0), out=share)


def _smooth(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Sums (n - 4, m) of five rows of (n, m), weighted by 1, 4, 6, 4 and 1."""
    for _ in range(4):
        values = values[:-1] + values[1:]
    return values


def _twice_as_fine(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Two rows (2 n, m) for each of (n, m), a quarter of a row before and after it."""
    result = np.repeat(values * np.float32(0.75), 2, axis=0)
    quarter = values * np.float32(0.25)
    result[2::2] += quarter[:-1]
    result[1:-1:2] += quarter[1:]
    return result


def _window_of(blocked: NDArray[np.bool_]) -> tuple[slice, slice] | None:
    """Rows and columns that hold all blocked texels and a margin; None when there are none."""
    rows, columns = (np.flatnonzero(blocked.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    first, last = (
        slice(max(int(own[0]) - _MARGIN, 0) & ~1, min(int(own[-1]) + _MARGIN + 1, _SIZE) & ~1) for own in (rows, columns)
    )
    return first, last


def _of_neighbours(function: np.ufunc, values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Of every texel but those at the border, the least or greatest of 3 x 3."""
    across = function(function(values[:, :-2], values[:, 2:]), values[:, 1:-1])
    result: NDArray[np.float32] = function(function(across[:-2], across[2:]), across[1:-1])
    return result


def spots_of(light: CameraView, view: CameraView, points: NDArray[np.float32]) -> LightSpots:
    """Find points (3, n) [m] in the frame of a camera in shadow maps taken with `light`."""
    x, y, z = points
    found = []
    for a, b, c, shift in (light.to_image @ view.extrinsics()).astype(np.float32):
        value = x * a
        value += y * b
        value += z * c
        value += shift
        found.append(value)
    return _spots(*found)


def spots_in_image(light: CameraView, view: CameraView, depth: NDArray[np.float32]) -> LightSpots:
    """Find what all pixels of a camera see in shadow maps taken with `light`.

    Args:
        light: Camera of the light.
        view: The camera.
        depth: What it sees, (h, w) [m].
    """
    matrix = light.to_image @ view.extrinsics()
    columns, rows = pixel_rays(view)
    found = []
    for a, b, c, shift in matrix:
        slope = (b * rows + c).astype(np.float32)[:, None] + (a * columns).astype(np.float32)
        slope *= depth
        slope += np.float32(shift)
        found.append(slope.ravel())
    return _spots(*found)


def _spots(u: NDArray[np.float32], v: NDArray[np.float32], depth: NDArray[np.float32]) -> LightSpots:
    """Spots of homogeneous image points u z, v z and z (n,); overwrites the first two."""
    last = np.float32(_SIZE - 1.501)
    for values in (u, v):
        values /= depth
        values += np.float32(0.5)
        np.maximum(values, np.float32(1.0), out=values)
        np.minimum(values, last, out=values)
    column, row = np.floor(u), np.floor(v)
    u -= column
    v -= row
    row *= np.float32(_SIZE)
    row += column
    return LightSpots(row.astype(np.int64), u, v, depth)
