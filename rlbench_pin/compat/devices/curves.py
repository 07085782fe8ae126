"""Paths through poses: their points in the world, and places along them."""

from __future__ import annotations

import numpy as np

from rlbench_pin.compat.things import Element, ObjectTable
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.spatial import FloatArray, compose
from rlbench_pin.tasks.waypoints import waypoints_of


class EmptyPath(RlbenchPinError, ValueError):
    """A path without points was asked for a place."""


def world_points(table: ObjectTable, element: Element) -> FloatArray:
    """Return the poses (n, 7) of the points of a path in the world.

    Raises:
        EmptyPath: It has no points.
    """
    frame = table.thing(element).pose
    if element.kind == "placed":
        placed = table.placed[element.name]
        points = [compose(frame, point) for point in placed.points]
        points += points[:1] if placed.extra.get("closed") else []
    else:
        points = [np.asarray(p) for p in _waypoint_points(table, element.name)]
    if not points:
        raise EmptyPath(f"The path '{table.name(element)}' has no points. Add some with `insert_control_points`.")
    return np.array(points)


def _waypoint_points(table: ObjectTable, name: str) -> list[FloatArray]:
    """Points of a curve of the scene file; a sweep begins where the waypoint before it is."""
    waypoints = waypoints_of(table.world)
    index = next(k for k, waypoint in enumerate(waypoints) if waypoint.frame.name == name)
    before = waypoints[index - 1].pose if index else table.world.robot.tip_pose()
    return waypoints[index].curve_poses(before)


def pose_at(poses: FloatArray, share: float) -> FloatArray:
    """Return the pose (7,) at a share of the length of a path, straight between its points.

    Args:
        poses: Points (n, 7).
        share: 0 at the first to 1 at the last.
    """
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1))])
    along = np.clip(share, 0.0, 1.0) * lengths[-1]
    index = int(np.clip(np.searchsorted(lengths, along, side="right") - 1, 0, max(len(poses) - 2, 0)))
    if len(poses) == 1 or lengths[index + 1] == lengths[index]:
        return np.array(poses[index])
    part = (along - lengths[index]) / (lengths[index + 1] - lengths[index])
    position = (1.0 - part) * poses[index, :3] + part * poses[index + 1, :3]
    return np.concatenate([position, slerp(poses[index, 3:], poses[index + 1, 3:], float(part))])


def slerp(first: FloatArray, second: FloatArray, share: float) -> FloatArray:
    """Return the quaternion (4,) at a share of the shorter way from one to another."""
    dot = float(np.dot(first, second))
    end = second if dot >= 0.0 else -second
    angle = float(np.arccos(np.clip(abs(dot), 0.0, 1.0)))
    if angle < 1e-9:
        return np.array(first)
    mixed: FloatArray = (np.sin((1.0 - share) * angle) * first + np.sin(share * angle) * end) / np.sin(angle)
    return mixed
