"""Cameras that have the whole task and the arm in their picture, and little else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rlbench_pin.robot.geometry import box_corners
from rlbench_pin.sim import CameraView, World, look_at
from rlbench_pin.spatial import FloatArray, above_table

NEAR, FAR = 0.05, 6.0
_ARM = np.array([(x, y, above_table(z)) for x in (-0.45, 0.15) for y in (-0.2, 0.2) for z in (0.0, 1.0)])
"""Corners of a box around the arm as it moves most of the time [m]."""
_MARGIN = 1.06
_NARROWEST, _WIDEST = 0.45, 1.6
"""Fields of view [rad]."""


def things_to_see(world: World) -> FloatArray:
    """Return points (n, 3) around the arm and all that the task brings [m]."""
    boxes = [box_corners(body.bounds(), body.pose) for body in world.bodies.values()]
    return np.concatenate([_ARM, world.robot.tip_pose()[None, :3], *boxes])


def field_of_view(view: CameraView, points: FloatArray) -> float:
    """Return the field of view of the longer side that has points (n, 3) in the picture of a camera [rad]."""
    across = np.abs(_slopes(view, points)).max(axis=0) * max(view.size) / np.array(view.size)
    return float(np.clip(2.0 * np.arctan(_MARGIN * across.max()), _NARROWEST, _WIDEST))


def framed(eye: Sequence[float], points: FloatArray, size: tuple[int, int]) -> CameraView:
    """Return the camera at a place that has points (n, 3) in its picture, as large as they can be."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    view = CameraView(pose=look_at(eye, middle), fov=_WIDEST, size=size, near=NEAR, far=FAR)
    for _ in range(4):
        slopes = _slopes(view, points)
        center = (slopes.min(axis=0) + slopes.max(axis=0)) / 2.0
        aim = view.extrinsics()[:3] @ [*center, 1.0, 1.0]
        view = replace(view, pose=look_at(eye, aim))
    return replace(view, fov=field_of_view(view, points))


def _slopes(view: CameraView, points: FloatArray) -> FloatArray:
    """Where points (n, 3) lie in the picture, as slopes (n, 2) to the left and up from its middle; none behind the camera."""
    local = (points - view.pose[:3]) @ view.extrinsics()[:3, :3]
    return local[:, :2] / np.maximum(local[:, 2:], NEAR)
