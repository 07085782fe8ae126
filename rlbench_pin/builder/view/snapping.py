"""Poses that fall into place: on a grid, on the table, on the surface below."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.scene import BodySpec, SceneSpec, resolve_asset
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray, pose_to_matrix
from rlbench_pin.urdf import read_urdf

Snap = Literal["free", "grid", "table", "surface below"]
"""What a thing that is dragged falls onto."""
SNAPS: tuple[Snap, ...] = ("free", "grid", "table", "surface below")
GRID = 0.01
"""Distance of places of the grid [m]."""
_TURN = np.radians(15.0)


def on_grid(pose: FloatArray) -> FloatArray:
    """Return a pose (7,) with its place on the grid of 1 cm; its height counts from the table top."""
    snapped = pose.copy()
    snapped[:2] = np.round(pose[:2] / GRID) * GRID
    snapped[2] = TABLE_HEIGHT + np.round((pose[2] - TABLE_HEIGHT) / GRID) * GRID
    return snapped


def resting_on(pose: FloatArray, points: FloatArray, height: float) -> FloatArray:
    """Return a pose (7,) lifted or lowered so that its lowest point is at a height [m].

    Args:
        pose: Of the thing.
        points: Its corners (n, 3) in its own frame; none for what has no extent.
        height: World z [m].
    """
    snapped = pose.copy()
    lowest = 0.0 if len(points) == 0 else float((points @ pose_to_matrix(pose)[2, :3]).min())
    snapped[2] = round(height - lowest, 6)
    return snapped


def height_below(points: FloatArray, others: FloatArray) -> float:
    """Return the height [m] of the highest surface below a thing; that of the table where there is none.

    Args:
        points: Corners (n, 3) of the thing in the world.
        others: Triangles (m, 3, 3) in the world.
    """
    if len(points) == 0 or len(others) == 0:
        return TABLE_HEIGHT
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    middle = 0.5 * (points[:, 2].min() + points[:, 2].max())
    flat_low, flat_high = others[:, :, :2].min(axis=1), others[:, :, :2].max(axis=1)
    under = ((flat_low < high) & (flat_high > low)).all(axis=1) & (others[:, :, 2].max(axis=1) <= middle)
    return max(TABLE_HEIGHT, float(others[under, :, 2].max())) if under.any() else TABLE_HEIGHT


def body_triangles(spec: SceneSpec, body: BodySpec, links: Mapping[str, FloatArray]) -> FloatArray:
    """Return the triangles (m, 3, 3) of what collides of a body, its links being at world poses (7,) by `<body>/<link>`.

    A body whose file cannot be read has none.
    """
    found = []
    try:
        for link in read_urdf(resolve_asset(spec, body.asset)).links:
            pose = links.get(f"{body.name}/{link.name}")
            for shape in link.collisions or link.visuals:
                if pose is not None and shape.kind:
                    corners, triangles = shape_surface(shape, body.scale)
                    matrix = pose_to_matrix(pose)
                    found.append((corners @ matrix[:3, :3].T + matrix[:3, 3])[triangles])
    except RlbenchPinError:
        return np.zeros((0, 3, 3))
    return np.concatenate(found) if found else np.zeros((0, 3, 3))


def whole_turn(pose: FloatArray) -> FloatArray:
    """Return a pose (7,) whose yaw is a multiple of 15 degrees when its z axis points up or down."""
    matrix = pose_to_matrix(pose)
    if abs(matrix[2, 2]) < 0.999:
        return pose
    yaw = float(np.arctan2(matrix[1, 0], matrix[0, 0]))
    half = 0.5 * (np.round(yaw / _TURN) * _TURN - yaw)
    x, y, z, w = pose[3:]
    sine, cosine = np.sin(half), np.cos(half)
    turned = np.array([cosine * x - sine * y, cosine * y + sine * x, cosine * z + sine * w, cosine * w - sine * z])
    return np.concatenate([pose[:3], turned])
