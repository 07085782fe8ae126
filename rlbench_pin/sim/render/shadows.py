"""Shadows of the key light: one picture of the moving things from the light, shared by all cameras of an observation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.sim.render.camera import CameraView, look_at
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

    first: NDArray[np.int32]
    """Upper left texel (n,)."""
    right: NDArray[np.float32]
    """Weight of the right texels (n,)."""
    down: NDArray[np.float32]
    """Weight of the lower texels (n,)."""
    depth: NDArray[np.float32]
    """Distance along the light (n,) [m]."""


class ShadowMap:
    """How far the key light gets.

    Args:
        view: Camera of the light.
        depth: Distance (n, n) along the light to the first moving thing [m]; `view.far` where there is none.
    """

    def __init__(self, view: CameraView, depth: NDArray[np.float32]) -> None:
        blocked = np.where(depth < view.far, depth, _FAR)
        blocked[0], blocked[-1], blocked[:, 0], blocked[:, -1] = _FAR, _FAR, _FAR, _FAR
        self.view, self._depth = view, blocked.ravel()
        self.is_empty = bool((blocked >= _FAR).all())

    def lit(self, spots: LightSpots, bias: NDArray[np.float32] | float = _ROOM_BIAS) -> NDArray[np.float32]:
        """Share (n,) of the key light that reaches points, 0..1.

        Args:
            spots: The points, from `spots_of`.
            bias: By how much a thing must be nearer to the light to shade a point [m].
        """
        limit = spots.depth - np.float32(bias)
        free = [(self._depth[spots.first + step] >= limit).astype(np.float32) for step in (0, 1, _SIZE, _SIZE + 1)]
        upper = free[0] + (free[1] - free[0]) * spots.right
        lower = free[2] + (free[3] - free[2]) * spots.right
        return upper + (lower - upper) * spots.down


def spots_of(view: CameraView, points: NDArray[np.float32]) -> LightSpots:
    """Find points (n, 3) [m] in shadow maps taken with `view`."""
    matrix = np.linalg.inv(view.extrinsics())
    x, y, depth = (points @ matrix[:3, :3].T.astype(np.float32) + matrix[:3, 3].astype(np.float32)).T
    k = view.intrinsics()
    u = np.clip(np.float32(k[0, 0]) * x / depth + np.float32(k[0, 2]), 0.0, _SIZE - 1.001)
    v = np.clip(np.float32(k[1, 1]) * y / depth + np.float32(k[1, 2]), 0.0, _SIZE - 1.001)
    column, row = u.astype(np.int32), v.astype(np.int32)
    return LightSpots(row * _SIZE + column, u - column, v - row, depth)
