"""Poses of elements: as typed numbers, snapped, resting on surfaces, at a free place, over a body."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot.geometry import shape_surface
from rlbench_pin.scene import BodySpec, SceneSpec, resolve_asset
from rlbench_pin.scene.spec import ROOT, PosedSpec
from rlbench_pin.spatial import IDENTITY, TABLE_HEIGHT, FloatArray, PoseLike, compose, inverse, pose_at, pose_to_matrix
from rlbench_pin.urdf import read_urdf
from rlbench_pin.viewer.places import Places, places_at_rest

Vector3 = tuple[float, float, float]
Snap = Literal["free", "grid", "table", "surface below"]
"""Snapping of a dragged element."""
SNAPS: tuple[Snap, ...] = ("free", "grid", "table", "surface below")
GRID = 0.01
"""Spacing of the grid [m]."""
_YAW_STEP = np.radians(15.0)
_LENGTH_DECIMALS, _ANGLE_DECIMALS = 4, 2
_STEP, _GAP = 0.05, 0.01
_DEPTH, _ABOVE, _SAME_WIDTH = 0.03, 0.1, 0.002
"""Depth of a grasp below the top at most, height of the pose above it, and difference of widths that counts as none [m]."""
_MARGIN_BESIDE, _MARGIN_BELOW = 0.02, 0.03
"""Tolerances beside a body and below its top for a drop onto it [m]."""

# Poses as numbers ----------------------------------------------------------------------------------------------------


def position_of(pose: PoseLike) -> Vector3:
    """Return x, y, z of a pose (7,) [m], rounded."""
    x, y, z = (round(float(v), _LENGTH_DECIMALS) + 0.0 for v in pose[:3])
    return x, y, z


def angles_of(pose: PoseLike) -> Vector3:
    """Return roll, pitch, yaw of a pose (7,) [deg], rounded: Rz(yaw) Ry(pitch) Rx(roll)."""
    m = pose_to_matrix(pose)
    across = math.hypot(m[0, 0], m[1, 0])
    pitch = math.atan2(-m[2, 0], across)
    if across > 1e-6:
        angles = math.atan2(m[2, 1], m[2, 2]), pitch, math.atan2(m[1, 0], m[0, 0])
    else:
        angles = math.atan2(-m[1, 2], m[1, 1]), pitch, 0.0
    roll, pitch, yaw = (_wrap(round(math.degrees(angle), _ANGLE_DECIMALS)) for angle in angles)
    return roll, pitch, yaw


def pose_of(position: Vector3, angles: Vector3) -> FloatArray:
    """Return the pose (7,) at a position [m] with roll, pitch, yaw [deg], without rounding noise."""
    roll, pitch, yaw = (math.radians(angle) for angle in angles)
    pose = pose_at(position, roll, pitch, yaw)
    if pose[6] < -1e-12:
        pose[3:] *= -1.0
    return np.round(pose, 12) + 0.0


def tidy(pose: PoseLike) -> FloatArray:
    """Return a pose (7,) rounded to typed numbers."""
    return pose_of(position_of(pose), angles_of(pose))


def in_frame(pose: PoseLike, frame: PoseLike) -> FloatArray:
    """Return a world pose (7,) relative to a frame (7,), rounded to typed numbers."""
    return tidy(compose(inverse(frame), pose))


def _wrap(degrees: float) -> float:
    """Return -180 as 180, and -0 as 0."""
    return 180.0 if degrees == -180.0 else degrees + 0.0


# Snapping ------------------------------------------------------------------------------------------------------------


def on_grid(pose: FloatArray) -> FloatArray:
    """Return a pose (7,) with its position on a grid of 1 cm; heights count from the table top."""
    snapped = pose.copy()
    snapped[:2] = np.round(pose[:2] / GRID) * GRID
    snapped[2] = TABLE_HEIGHT + np.round((pose[2] - TABLE_HEIGHT) / GRID) * GRID
    return snapped


def resting_on(pose: FloatArray, points: FloatArray, height: float) -> FloatArray:
    """Return a pose (7,) moved vertically so that the lowest point is at a height [m].

    Args:
        pose: Pose of the object.
        points: Its vertices (n, 3) in its own frame; none for an object without extent.
        height: World z [m].
    """
    snapped = pose.copy()
    lowest = 0.0 if len(points) == 0 else float((points @ pose_to_matrix(pose)[2, :3]).min())
    snapped[2] = round(height - lowest, 6)
    return snapped


def height_below(points: FloatArray, others: FloatArray) -> float:
    """Return the height [m] of the highest surface below an object; the table top if there is none.

    Args:
        points: Vertices (n, 3) of the object in the world.
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
    """Return the collision triangles (m, 3, 3) of a body with its links at world poses (7,), by `<body>/<link>`.

    An unreadable file gives none.
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


def snap_yaw(pose: FloatArray) -> FloatArray:
    """Return a pose (7,) with its yaw rounded to 15 degrees, if its z axis points up or down."""
    matrix = pose_to_matrix(pose)
    if abs(matrix[2, 2]) < 0.999:
        return pose
    yaw = float(np.arctan2(matrix[1, 0], matrix[0, 0]))
    half = 0.5 * (np.round(yaw / _YAW_STEP) * _YAW_STEP - yaw)
    x, y, z, w = pose[3:]
    sine, cosine = np.sin(half), np.cos(half)
    turned = np.array([cosine * x - sine * y, cosine * y + sine * x, cosine * z + sine * w, cosine * w - sine * z])
    return np.concatenate([pose[:3], turned])


def own_points(spec: SceneSpec, body: BodySpec) -> FloatArray:
    """Return the collision vertices (n, 3) of a body in its own frame."""
    joints = tuple(joint for joint in spec.joint if joint.name.startswith(f"{body.name}/"))
    alone = SceneSpec(format=2, body=(body.model_copy(update={"parent": ROOT}),), joint=joints, file=spec.file)
    links = places_at_rest(alone, {body.name: IDENTITY.copy()}).links
    return body_triangles(alone, body, links).reshape(-1, 3)


# Grasps --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class TopGrasp:
    """A grasp from above, across the narrowest side of an object."""

    pose: FloatArray
    """Pose (7,) of the tip in the world, z down: at the middle of the object, at most 3 cm below its top."""
    width: float
    """Size of the object along the opening of the fingers [m]."""
    symmetry: int
    """12, 4 or 2: that many rotations about z grasp the object as well."""

    def above(self) -> FloatArray:
        """Return the pose (7,) of the tip 10 cm above the grasp."""
        return compose(self.pose, pose_at((0.0, 0.0, -_ABOVE)))


def top_grasp(pose: FloatArray, points: FloatArray) -> TopGrasp:
    """Return the grasp from above of an object.

    Args:
        pose: Pose (7,) of the object in the world.
        points: Its vertices (n, 3) in its own frame, at least one.
    """
    matrix = pose_to_matrix(pose)
    corners = points @ matrix[:3, :3].T + matrix[:3, 3]
    first = math.atan2(matrix[1, 0], matrix[0, 0])
    yaws = first + np.arange(12) * _YAW_STEP
    spans = [np.ptp(corners[:, :2] @ (math.sin(yaw), -math.cos(yaw))) for yaw in yaws]  # along y of the tip
    best = int(np.argmin(np.round(spans, 4)))
    width = float(spans[best])
    alike = [abs(span - width) < _SAME_WIDTH for span in spans]
    symmetry = 12 if all(alike) else 4 if alike[best - 6] else 2
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y, z = (low + high) / 2.0
    return TopGrasp(pose_at((x, y, max(z, high[2] - _DEPTH)), math.pi, 0.0, float(yaws[best])), width, symmetry)


# Free places and drop targets ----------------------------------------------------------------------------------------


def free_place(spec: SceneSpec, body: BodySpec) -> tuple[float, float, float]:
    """Return a free place on the table for a new body, in the frame of the root, near its origin."""
    alone = SceneSpec(format=2, body=(body,), file=spec.file)
    points = body_triangles(alone, body, places_at_rest(alone, {body.name: IDENTITY.copy()}).links).reshape(-1, 3)
    places = places_at_rest(spec)
    root = places.of(ROOT)
    assert root is not None
    height = float(resting_on(IDENTITY, points, TABLE_HEIGHT)[2]) - float(root[2])
    taken = list(_patches(spec, places))
    low, high = (points.min(axis=0)[:2], points.max(axis=0)[:2]) if len(points) else (np.zeros(2), np.zeros(2))
    for x, y in _spiral():
        here = np.array([x, y])
        if not any((low + here - _GAP < top).all() and (high + here + _GAP > bottom).all() for bottom, top in taken):
            return x, y, round(height, 4)
    return 0.0, 0.0, round(height, 4)


def _patches(spec: SceneSpec, places: Places) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield lowest and highest x, y of bodies, relative to the root."""
    root = places.of(ROOT)
    assert root is not None
    for body in spec.body:
        points = body_triangles(spec, body, places.links).reshape(-1, 3)
        if len(points):
            yield points.min(axis=0)[:2] - root[:2], points.max(axis=0)[:2] - root[:2]


def _spiral() -> Iterator[tuple[float, float]]:
    """Yield positions on a grid, the nearest first."""
    cells = sorted(product(range(-4, 5), range(-6, 7)), key=lambda cell: (cell[0] ** 2 + cell[1] ** 2, cell[1] < 0, cell))
    yield from ((round(x * _STEP, 4), round(y * _STEP, 4)) for x, y in cells)


class DropTargets:
    """The bodies onto which a dragged element can be dropped: all that are not attached to it.

    Args:
        spec: The scene.
        links: World pose (7,) of each link, by `<body>/<link>`.
        name: Name of the dragged element.
    """

    def __init__(self, spec: SceneSpec, links: Mapping[str, FloatArray], name: str) -> None:
        self._boxes: dict[str, FloatArray] = {}
        for body in spec.body:
            corners = body_triangles(spec, body, links).reshape(-1, 3)
            if len(corners) and not is_attached_to(spec, body, name):
                self._boxes[body.name] = np.array([corners.min(axis=0), corners.max(axis=0)])

    def below(self, point: FloatArray) -> str:
        """Return the highest body over or in which a world point (3,) is; empty if there is none."""
        found = [
            (box[1, 2], name)
            for name, box in self._boxes.items()
            if (box[0, :2] - _MARGIN_BESIDE <= point[:2]).all()
            and (point[:2] <= box[1, :2] + _MARGIN_BESIDE).all()
            and (point[2] >= box[1, 2] - _MARGIN_BELOW or (box[0] <= point).all() and (point <= box[1]).all())
        ]
        return max(found)[1] if found else ""

    def box(self, name: str) -> FloatArray:
        """Return the lowest and the highest corner (2, 3) of the box of a body in the world [m]."""
        return self._boxes[name].copy()


def is_attached_to(spec: SceneSpec, element: PosedSpec, name: str) -> bool:
    """Return whether an element is the one of that name, or is attached to it, directly or not."""
    parents = {other.name: other.parent.partition("/")[0] for other in spec.posed()}
    here = element.name
    for _ in range(len(parents) + 1):
        if here == name:
            return True
        here = parents.get(here, "")
    return False
