"""Cartesian paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from pyrep.errors import PyRepError
from pyrep.objects.object import Object, euler_to_quaternion, matrix_to_euler
from rlbench_pin.compat.objects import Element, ObjectType, Placed
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.spatial import IDENTITY, FloatArray, compose, pose_to_matrix, relative
from rlbench_pin.tasks.waypoints import waypoints_of


class EmptyPath(RlbenchPinError, ValueError):
    """A path without points has no poses."""


class CartesianPath(Object):
    """A curve through poses: a waypoint of the scene with `path = "curve"`, or a path that a program created."""

    kinds: ClassVar[tuple[ObjectType, ...]] = ("path",)

    @classmethod
    def create(
        cls,
        show_line: bool = True,
        show_orientation: bool = True,
        show_position: bool = True,
        closed_path: bool = False,
        automatic_orientation: bool = True,
        flat_path: bool = False,
        keep_x_up: bool = False,
        line_size: int = 1,
        length_calculation_method: int = 0,
        control_point_size: float = 0.01,
        ang_to_lin_conv_coeff: float = 1.0,
        virt_dist_scale_factor: float = 1.0,
        paths: Sequence[float] | None = None,
    ) -> CartesianPath:
        """Create a path without points at the origin of the world; it exists until `remove()`. Paths are not drawn.

        * `closed_path`: connect the last point to the first.
        * All other arguments have no effect: orientations are those of the points, and only positions count for the length.
        """
        table = Simulator.current().objects
        name = table.free_name("Path")
        table.placed[name] = Placed("path", IDENTITY.copy(), extra={"closed": closed_path})
        return cls(Element("placed", name))

    def insert_control_points(self, poses: Sequence[Sequence[float]]) -> None:
        """Append points.

        Args:
            poses: Points: x, y, z [m] and Euler angles a, b, c [rad], in world coordinates.
        """
        if self.element.kind != "placed":
            raise PyRepError(
                f"The points of '{self.get_name()}' are part of the scene file. Create a path with `CartesianPath.create`."
            )
        placed, frame = self.table.placed[self.element.name], self.get_pose()
        points = [relative(_pose_of(pose), frame) for pose in poses]
        self.table.placed[self.element.name] = replace(placed, points=(*placed.points, *points))

    def get_poses(self) -> FloatArray:
        """Return the world poses (n, 7) of the points; a closed path repeats the first pose at the end.

        Raises:
            EmptyPath: The path has no points.
        """
        table, element, frame = self.table, self.element, self.get_pose()
        if element.kind == "placed":
            placed = table.placed[element.name]
            points = [compose(frame, point) for point in placed.points]
            points += points[:1] if placed.extra.get("closed") else []
        else:
            points = self._waypoint_points()
        if not points:
            raise EmptyPath(f"The path '{self.get_name()}' has no points. Add some with `insert_control_points`.")
        return np.array(points)

    def _waypoint_points(self) -> list[FloatArray]:
        """Return the points of a curve of the scene file; a sweep starts at the previous waypoint."""
        waypoints = waypoints_of(self.table.world)
        index = next(k for k, waypoint in enumerate(waypoints) if waypoint.frame.name == self.element.name)
        before = waypoints[index - 1].pose if index else self.table.world.robot.tip_pose()
        return [np.asarray(pose) for pose in waypoints[index].curve_poses(before)]

    def get_pose_on_path(self, relative_distance: float) -> tuple[list[float], list[float]]:
        """Return position [m] and Euler angles [rad] at a fraction of the length.

        Args:
            relative_distance: Fraction of the length, from 0 (first point) to 1 (last point).
        """
        pose = _pose_at(self.get_poses(), float(relative_distance))
        return pose[:3].tolist(), matrix_to_euler(pose_to_matrix(pose)[:3, :3]).tolist()


def _pose_of(numbers: Sequence[float]) -> FloatArray:
    """Return the pose (7,) of x, y, z [m] and Euler angles a, b, c [rad]."""
    return np.concatenate([numbers[:3], euler_to_quaternion(numbers[3:6])])


def _pose_at(poses: FloatArray, share: float) -> FloatArray:
    """Return the pose (7,) at a fraction of the length of a path, by interpolation between its points.

    Args:
        poses: Points (n, 7).
        share: Fraction of the length, from 0 (first point) to 1 (last point).
    """
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1))])
    along = np.clip(share, 0.0, 1.0) * lengths[-1]
    index = int(np.clip(np.searchsorted(lengths, along, side="right") - 1, 0, max(len(poses) - 2, 0)))
    if len(poses) == 1 or lengths[index + 1] == lengths[index]:
        return np.array(poses[index])
    part = (along - lengths[index]) / (lengths[index + 1] - lengths[index])
    position = (1.0 - part) * poses[index, :3] + part * poses[index + 1, :3]
    return np.concatenate([position, _slerp(poses[index, 3:], poses[index + 1, 3:], float(part))])


def _slerp(first: FloatArray, second: FloatArray, share: float) -> FloatArray:
    """Return the spherical interpolation of two quaternions (4,), along the shorter rotation."""
    dot = float(np.dot(first, second))
    end = second if dot >= 0.0 else -second
    angle = float(np.arccos(np.clip(abs(dot), 0.0, 1.0)))
    if angle < 1e-9:
        return np.array(first)
    mixed: FloatArray = (np.sin((1.0 - share) * angle) * first + np.sin(share * angle) * end) / np.sin(angle)
    return mixed
