"""Shadows of the key light: one picture of the moving things from the light, shared by all cameras of an observation.

A point is in shadow as far as texels around its place are nearer to the light: a square of 3 x 3, of which each of 4 x 4 counts
by what of it lies there. Most points lie beyond all of these texels or before them all, which two looks tell; only those
at edges are looked at sixteen times. The same picture says where things stand on the table: what of them is seen low above it
keeps light from around their feet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView, pixel_rays
from rlbench_pin.sim.render.lighting import Light
from rlbench_pin.spatial import TABLE_HEIGHT, matrix_to_pose

_CENTER = np.array([0.15, 0.0, TABLE_HEIGHT + 0.1])
_REACH = 0.86  # half a side of the square around the centre whose shadows are drawn [m]
_DISTANCE = 30.0  # far away, so that its rays are almost parallel [m]
_SIZE = 320
_ROOM_BIAS = 0.002  # [m]
_FAR = np.float32(1e6)
_MARGIN = 8  # texels that a shadow, or what things keep from the table, reaches beyond them
_LOW, _HIGH = (0.002, 0.014), (0.02, 0.09)
"""Between these heights above the table things begin to darken it, and cease to [m]."""
_DARKENING = np.float32(0.45)
_ON_TABLE = np.float32(0.01)  # so near the table top points count as its own [m]
_STEPS = tuple(tuple(row * _SIZE + column for column in range(-1, 3)) for row in range(-1, 3))


def light_view(light: Light) -> CameraView:
    """The camera that sees what the light reaches; its picture lies along the sides of the table."""
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
    """Where points lie in a shadow map: four texels with weights, and the distance from the light."""

    first: NDArray[np.int64]
    """Upper left texel (n,)."""
    right: NDArray[np.float32]
    """Weight of the right texels (n,)."""
    down: NDArray[np.float32]
    """Weight of the lower texels (n,)."""
    depth: NDArray[np.float32]
    """Distance along the light (n,) [m]."""

    def at(self, chosen: NDArray[np.int64]) -> LightSpots:
        """Return some of them."""
        return LightSpots(self.first.take(chosen), self.right.take(chosen), self.down.take(chosen), self.depth.take(chosen))


def joined_spots(spots: Sequence[LightSpots]) -> LightSpots:
    """Return some spots after each other."""
    return LightSpots(*(np.concatenate([getattr(s, name) for s in spots]) for name in ("first", "right", "down", "depth")))


class ShadowMap:
    """How far the key light gets.

    Args:
        view: Camera of the light.
        depth: Distance (n, n) along the light to the first moving thing [m]; `view.far` where there is none.

    Attributes:
        is_empty: Whether nothing stands in the light.
    """

    def __init__(self, view: CameraView, depth: NDArray[np.float32]) -> None:
        blocked = np.where(depth < view.far, depth, _FAR)
        for edge in (blocked[:2], blocked[-3:], blocked[:, :2], blocked[:, -3:]):
            edge[:] = _FAR
        self.view, self._blocked, self._depth = view, blocked, blocked.ravel()
        self._window = _window_of(blocked < _FAR)
        self.is_empty = self._window is None
        self._least, self._greatest = (np.full((_SIZE, _SIZE), _FAR, dtype=np.float32) for _ in range(2))
        if self._window is not None:
            rows, columns = self._window
            seen = blocked[rows, columns]
            inner = slice(rows.start + 1, rows.stop - 2), slice(columns.start + 1, columns.stop - 2)
            self._least[inner], self._greatest[inner] = _of_neighbours(np.minimum, seen), _of_neighbours(np.maximum, seen)

    @cached_property
    def is_near(self) -> NDArray[np.bool_]:
        """Of every texel (n * n,), whether one of those around it is blocked, or the table is darker there."""
        return ((self._least < _FAR) | (self._contact > 0.0)).ravel()

    @cached_property
    def _contact(self) -> NDArray[np.float32]:
        """How much of the light from all sides things keep from the table (n, n), 0..1."""
        result = np.zeros((_SIZE, _SIZE), dtype=np.float32)
        if self._window is not None:
            height = _ground(self.view)[self._window] - self._blocked[self._window]
            height *= np.float32(-self.view.extrinsics()[2, 2])
            share = np.clip((height - _LOW[0]) * np.float32(1.0 / (_LOW[1] - _LOW[0])), 0.0, 1.0)
            share *= np.clip((_HIGH[1] - height) * np.float32(1.0 / (_HIGH[1] - _HIGH[0])), 0.0, 1.0)
            coarse = share[0::2, 0::2] + share[1::2, 0::2] + share[0::2, 1::2] + share[1::2, 1::2]
            for _ in range(2):
                coarse = _mean_of_three(_mean_of_three(coarse).T).T
            coarse *= np.float32(0.25) * _DARKENING
            result[self._window] = _twice_as_fine(_twice_as_fine(coarse).T).T
        return result

    def open(self, spots: LightSpots) -> NDArray[np.float32]:
        """Share (n,) of the light from all sides that reaches points of the room, 0..1: less around what stands on the table."""
        first = spots.first
        parts = [self._contact.ravel().take(first + step) for step in (0, 1, _SIZE, _SIZE + 1)]
        upper = parts[0] + (parts[1] - parts[0]) * spots.right
        lower = parts[2] + (parts[3] - parts[2]) * spots.right
        upper += (lower - upper) * spots.down
        upper *= np.abs(_ground(self.view).ravel().take(first) - spots.depth) < _ON_TABLE
        return np.subtract(np.float32(1.0), upper, out=upper)

    def lit(self, spots: LightSpots, bias: NDArray[np.float32] | float = _ROOM_BIAS) -> NDArray[np.float32]:
        """Share (n,) of the key light that reaches points, 0..1.

        Args:
            spots: The points, from `spots_of`.
            bias: By how much a thing must be nearer to the light to shade a point [m].
        """
        limit = spots.depth - np.float32(bias)
        share = (self._least.ravel().take(spots.first) >= limit).astype(np.float32)
        reached = (share == 0.0).nonzero()[0]
        edge = reached.take((self._greatest.ravel().take(spots.first.take(reached)) >= limit.take(reached)).nonzero()[0])
        share[edge] = self._share(spots.at(edge), limit.take(edge))
        return share

    def _share(self, spots: LightSpots, limit: NDArray[np.float32]) -> NDArray[np.float32]:
        """Mean of 3 x 3 texels around points."""
        first, right, down = spots.first, spots.right, spots.down
        total = np.zeros(len(first), dtype=np.float32)
        for number, row in enumerate(_STEPS):
            free = [(self._depth.take(first + step) >= limit).astype(np.float32) for step in row]
            part = free[0] + free[1] + free[2]
            part += (free[3] - free[0]) * right
            if number in (0, 3):
                part *= down if number else np.float32(1.0) - down
            total += part
        total *= np.float32(1.0 / 9.0)
        return total


@lru_cache(maxsize=4)
def _ground(view: CameraView) -> NDArray[np.float32]:
    """Distance (n, n) along the light to the plane of the table top [m]."""
    rays = view.rays[:, 2].reshape(_SIZE, _SIZE)
    return (np.float32(TABLE_HEIGHT - view.pose[2]) / np.minimum(rays, np.float32(-1e-3))).astype(np.float32)


def _mean_of_three(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Of each row and those beside it; the first and the last stay."""
    result = values.copy()
    result[1:-1] += values[:-2]
    result[1:-1] += values[2:]
    result[1:-1] *= np.float32(1.0 / 3.0)
    return result


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
    """Of every texel but those at the border, the least or greatest of itself, the one before and the two after it, both ways."""
    pairs = function(values[:, :-1], values[:, 1:])
    across = function(pairs[:, :-2], pairs[:, 2:])
    pairs = function(across[:-1], across[1:])
    result: NDArray[np.float32] = function(pairs[:-2], pairs[2:])
    return result


def spots_of(light: CameraView, view: CameraView, points: NDArray[np.float32]) -> LightSpots:
    """Find points (3, n) [m] in the frame of a camera in shadow maps taken with `light`."""
    x, y, z = points
    found = []
    for a, b, c, shift in (light.to_picture @ view.extrinsics()).astype(np.float32):
        value = x * a
        value += y * b
        value += z * c
        value += shift
        found.append(value)
    return _spots(*found)


def spots_in_picture(light: CameraView, view: CameraView, depth: NDArray[np.float32]) -> LightSpots:
    """Find what all pixels of a camera see in shadow maps taken with `light`.

    Args:
        light: Camera of the light.
        view: The camera.
        depth: What it sees, (h, w) [m].
    """
    matrix = light.to_picture @ view.extrinsics()
    columns, rows = pixel_rays(view)
    found = []
    for a, b, c, shift in matrix:
        slope = (b * rows + c).astype(np.float32)[:, None] + (a * columns).astype(np.float32)
        slope *= depth
        slope += np.float32(shift)
        found.append(slope.ravel())
    return _spots(*found)


def _spots(u: NDArray[np.float32], v: NDArray[np.float32], depth: NDArray[np.float32]) -> LightSpots:
    """Spots of homogeneous picture points u z, v z and z (n,); overwrites the first two."""
    last = np.float32(_SIZE - 3.001)
    for values in (u, v):
        values /= depth
        np.maximum(values, np.float32(1.0), out=values)
        np.minimum(values, last, out=values)
    column, row = np.floor(u), np.floor(v)
    u -= column
    v -= row
    row *= np.float32(_SIZE)
    row += column
    return LightSpots(row.astype(np.int64), u, v, depth)
