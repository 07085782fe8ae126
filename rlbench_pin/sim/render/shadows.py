"""Shadows of the key light: one picture of the moving things from the light, shared by all cameras of an observation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView, look_at, pixel_rays
from rlbench_pin.sim.render.lighting import Light

_CENTER = np.array([0.2, 0.0, 1.0])
_REACH = 1.15  # radius of the ball around the centre whose shadows are drawn [m]
_DISTANCE = 30.0  # far away, so that its rays are almost parallel [m]
_SIZE = 256
_ROOM_BIAS = 0.002  # [m]
_FAR = np.float32(1e6)


def light_view(light: Light) -> CameraView:
    """The camera that sees what the light reaches."""
    eye = _CENTER + _DISTANCE * light.unit
    fov = 2.0 * float(np.arctan(_REACH / _DISTANCE))
    return CameraView(pose=look_at(eye, _CENTER), fov=fov, size=(_SIZE, _SIZE), near=_DISTANCE - 2.0, far=_DISTANCE + 2.0)


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
        is_near: Of every texel (n * n,), whether it, its right, lower or lower right neighbour is blocked.
    """

    def __init__(self, view: CameraView, depth: NDArray[np.float32]) -> None:
        blocked = np.where(depth < view.far, depth, _FAR)
        blocked[0], blocked[-1], blocked[:, 0], blocked[:, -1] = _FAR, _FAR, _FAR, _FAR
        self.view, self._depth = view, blocked.ravel()
        self.is_empty = bool((blocked >= _FAR).all())
        near = blocked < _FAR
        near[:, :-1] |= near[:, 1:]
        near[:-1] |= near[1:]
        self.is_near = near.ravel()

    def lit(self, spots: LightSpots, bias: NDArray[np.float32] | float = _ROOM_BIAS) -> NDArray[np.float32]:
        """Share (n,) of the key light that reaches points, 0..1.

        Args:
            spots: The points, from `spots_of`.
            bias: By how much a thing must be nearer to the light to shade a point [m].
        """
        limit = spots.depth - np.float32(bias)
        first = spots.first
        free = [(self._depth.take(first + step) >= limit).astype(np.float32) for step in (0, 1, _SIZE, _SIZE + 1)]
        upper = free[0] + (free[1] - free[0]) * spots.right
        lower = free[2] + (free[3] - free[2]) * spots.right
        return upper + (lower - upper) * spots.down


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
    last = np.float32(_SIZE - 1.001)
    for values in (u, v):
        values /= depth
        np.maximum(values, np.float32(0.0), out=values)
        np.minimum(values, last, out=values)
    column, row = np.floor(u), np.floor(v)
    u -= column
    v -= row
    row *= np.float32(_SIZE)
    row += column
    return LightSpots(row.astype(np.int64), u, v, depth)
