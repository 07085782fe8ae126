"""Shapes of URDF files as Coal geometry, geometric queries for sensors and fingers, and surfaces of shapes.

Meshes are replaced by their convex hulls, as in PyBullet. Mesh paths are relative to the URDF file.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Literal

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.errors import AssetInvalid, AssetNotFound
from rlbench_pin.scene.snapshot import Shape
from rlbench_pin.spatial import FloatArray, PoseLike
from rlbench_pin.urdf import UrdfOrigin, UrdfShape, read_urdf

Part = tuple[coal.CollisionGeometry, pin.SE3]
"""A shape and its placement T_link_shape."""
VolumeShape = Literal["box", "cylinder", "sphere"]
_FLAT, _THICKNESS = 1e-6, 1e-4  # [m]
_CAUTION = 1e-5
"""Distance between bounding spheres above which shapes cannot touch, including rounding [m]."""


@dataclass(frozen=True, eq=False)
class Ball:
    """A bounding sphere of the shapes of a link."""

    center: FloatArray
    """Centre in the link frame (3,) [m]."""
    radius: float
    """[m]"""


@cache
def link_geometry(urdf: Path, scale: float = 1.0) -> Mapping[str, tuple[Part, ...]]:
    """Return the collision shapes of each link of a URDF file, in file order; links without shapes are omitted."""
    return _read(urdf, scale, "collision")


@cache
def visual_geometry(urdf: Path, scale: float = 1.0) -> Mapping[str, tuple[Part, ...]]:
    """Return the visual shapes of each link as convex hulls; links without visuals are omitted."""
    return _read(urdf, scale, "visual")


@cache
def solid_geometry(urdf: Path, scale: float = 1.0) -> Mapping[str, tuple[Part, ...]]:
    """Return the collision shapes of a URDF file, or the visual shapes if it has none (markers)."""
    return link_geometry(urdf, scale) or visual_geometry(urdf, scale)


@cache
def solid_balls(urdf: Path, scale: float = 1.0) -> Mapping[str, Ball]:
    """Return a bounding sphere of the solid shapes of each link with shapes."""
    boxes = {link: bounds(parts) for link, parts in solid_geometry(urdf, scale).items()}
    balls = {link: Ball(0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low))) for link, (low, high) in boxes.items()}
    return MappingProxyType(balls)


def bounds(parts: Iterable[Part]) -> FloatArray:
    """Return the axis-aligned box [[min], [max]] (2, 3) of shapes in their link frame [m]; tight for hulls."""
    boxes = [_part_bounds(shape, placement) for shape, placement in parts]
    if not boxes:
        return np.zeros((2, 3))
    return np.stack([np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)])


@cache
def rigid_bounds(urdf: Path, scale: float = 1.0) -> FloatArray:
    """Return the box (2, 3) around the shapes of a body with a single link, in its own frame [m]; the array is read-only."""
    box = bounds(part for parts in solid_geometry(urdf, scale).values() for part in parts)
    box.setflags(write=False)
    return box


def extent_along(parts: Iterable[Part], T_world_link: pin.SE3, directions: FloatArray) -> FloatArray:
    """Return the extent of the shapes of a link along unit vectors (n, 3) of the world, [[lowest], [highest]] (2, n) [m]."""
    least, most = np.full(len(directions), np.inf), np.full(len(directions), -np.inf)
    for shape, T_link_shape in parts:
        placed = T_world_link * T_link_shape
        middle, turned = directions @ placed.translation, directions @ placed.rotation
        if isinstance(shape, coal.Convex):
            heights = turned @ np.array(shape.points()).T
            low, high = heights.min(axis=1), heights.max(axis=1)
        else:
            high = _half_extent(shape, turned)
            low = -high
        least, most = np.minimum(least, middle + low), np.maximum(most, middle + high)
    return np.stack([least, most])


def volume(shape: VolumeShape, size: Sequence[float]) -> coal.ShapeBase:
    """Build a sensor volume: box `x, y, z`; cylinder `diameter, length` along z; sphere `diameter` [m]."""
    if shape == "box":
        return coal.Box(*(float(s) for s in size))
    if shape == "cylinder":
        return coal.Cylinder(float(size[0]) / 2.0, float(size[1]))
    return coal.Sphere(float(size[0]) / 2.0)


@cache
def primitive(shape: Shape) -> Part:
    """Build a solid and its placement from plain numbers."""
    size, placement = shape.size, pin.XYZQUATToSE3(np.array(shape.pose))
    if shape.kind == "box":
        return coal.Box(*size), placement
    if shape.kind == "sphere":
        return coal.Sphere(*size), placement
    if shape.kind == "cylinder":
        return coal.Cylinder(*size), placement
    if shape.kind == "capsule":
        return coal.Capsule(*size), placement
    corners = coal.StdVec_Vec3s()
    corners.extend(list(np.reshape(size, (-1, 3))))
    hull = coal.Convex.convexHull(corners, True, "Qt")
    hull.computeLocalAABB()
    return hull, placement


def as_shape(part: Part) -> Shape:
    """Return a solid as plain numbers: the inverse of `primitive`."""
    solid, placement = part
    pose = tuple(pin.SE3ToXYZQUAT(placement).tolist())
    if isinstance(solid, coal.Box):
        return Shape("box", tuple((2.0 * solid.halfSide).tolist()), pose)
    if isinstance(solid, coal.Sphere):
        return Shape("sphere", (solid.radius,), pose)
    if isinstance(solid, (coal.Cylinder, coal.Capsule)):
        kind: Literal["cylinder", "capsule"] = "cylinder" if isinstance(solid, coal.Cylinder) else "capsule"
        return Shape(kind, (solid.radius, 2.0 * solid.halfLength), pose)
    return Shape("convex", tuple(np.ravel(solid.points()).tolist()), pose)


def volume_contains(shape: VolumeShape, size: Sequence[float], T_world_volume: pin.SE3, point: FloatArray) -> bool:
    """Return whether a world point (3,) is inside a sensor volume."""
    x = T_world_volume.actInv(np.asarray(point, dtype=float))
    if shape == "box":
        return all(abs(along) <= 0.5 * side for along, side in zip(x.tolist(), size, strict=True))
    if shape == "cylinder":
        return bool(np.hypot(x[0], x[1]) <= 0.5 * size[0] and abs(x[2]) <= 0.5 * size[1])
    return math.sqrt(x @ x) <= 0.5 * size[0]


def radius(shape: coal.ShapeBase) -> float:
    """Return the radius of the sphere around the origin that contains a box, cylinder, capsule or sphere [m]."""
    return float(np.linalg.norm(_half_extent(shape, np.eye(3))))


def is_near(ball: Ball, T_world_link: pin.SE3, T_world_volume: pin.SE3, reach: float) -> bool:
    """Return whether the sphere of a link (nearly) touches the sphere of radius `reach` [m] around the origin of a volume."""
    apart = T_world_link.act(ball.center) - T_world_volume.translation
    return not math.hypot(*apart.tolist()) > ball.radius + reach + _CAUTION


def overlaps(shape: coal.CollisionGeometry, T_world_shape: pin.SE3, parts: Iterable[Part], T_world_link: pin.SE3) -> bool:
    """Return whether a shape touches any of the shapes of a link."""
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    placed = to_transform(T_world_shape)
    for part, T_link_part in parts:
        if coal.collide(shape, placed, part, to_transform(T_world_link * T_link_part), request, result):
            return True
    return False


def gap(first: Iterable[Part], T_world_first: pin.SE3, second: Iterable[Part], T_world_second: pin.SE3) -> float:
    """Return the smallest distance between the shapes of two links [m]; 0 if they touch, infinity without shapes."""
    others = [(shape, to_transform(T_world_second * T_link_shape)) for shape, T_link_shape in second]
    least = float("inf")
    for shape, T_link_shape in first:
        placed = to_transform(T_world_first * T_link_shape)
        for other, there in others:
            result = coal.DistanceResult()
            least = min(least, max(0.0, coal.distance(shape, placed, other, there, coal.DistanceRequest(), result)))
    return least


def to_transform(placement: pin.SE3) -> coal.Transform3s:
    """Convert a Pinocchio placement to a Coal transform."""
    return coal.Transform3s(placement.rotation, placement.translation)


def to_placement(origin: UrdfOrigin | None, scale: float = 1.0) -> pin.SE3:
    """Return T_link_shape of an origin in a URDF file, lengths multiplied by `scale`."""
    if origin is None:
        return pin.SE3.Identity()
    return pin.SE3(pin.rpy.rpyToMatrix(np.array(origin.rpy)), scale * np.array(origin.xyz))


def box_corners(box: FloatArray, pose: PoseLike) -> FloatArray:
    """Return the eight corners (8, 3) in the world of a local box (2, 3) at a pose (7,)."""
    placement = pin.XYZQUATToSE3(np.asarray(pose, dtype=float))
    corners = np.array([[box[i, 0], box[j, 1], box[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    return corners @ placement.rotation.T + placement.translation


# Reading ----------------------------------------------------------------------------------------------------------


def _read(urdf: Path, scale: float, role: Literal["collision", "visual"]) -> Mapping[str, tuple[Part, ...]]:
    result: dict[str, tuple[Part, ...]] = {}
    for link in read_urdf(urdf, "the collision model").links:
        shapes = link.collisions if role == "collision" else link.visuals
        if shapes:
            result[link.name] = tuple((_solid(urdf, shape, scale), to_placement(shape.origin, scale)) for shape in shapes)
    return MappingProxyType(result)


def _solid(urdf: Path, shape: UrdfShape, scale: float) -> coal.CollisionGeometry:
    if shape.mesh is not None:
        return _hull(urdf, shape.mesh, scale * np.array(shape.size))
    build = {"box": coal.Box, "sphere": coal.Sphere, "cylinder": coal.Cylinder, "capsule": coal.Capsule}.get(shape.kind)
    if build is None:
        found = f"geometry '{shape.kind}'" if shape.kind else "an element without geometry"
        raise AssetInvalid(urdf, f"{found} is not one of box, sphere, cylinder, capsule, mesh")
    return build(*(scale * number for number in shape.size))


def _hull(urdf: Path, mesh: Path, scale: FloatArray) -> coal.Convex:
    if not mesh.is_file():
        raise AssetNotFound(mesh, urdf.name)
    surface = coal.MeshLoader().load(str(mesh), scale)
    if (flat := _thickened(np.array(surface.vertices()))) is not None:
        return flat
    try:
        surface.buildConvexHull(True, "Qt")
    except (RuntimeError, ValueError) as error:
        raise AssetInvalid(mesh, f"no convex hull: {error}") from error
    hull = surface.convex
    hull.computeLocalAABB()
    return hull


def _thickened(corners: FloatArray) -> coal.Convex | None:
    """Return a hull of 0.1 mm thickness around corners (n, 3) in one plane; None if they are not in a plane."""
    _, spread, axes = np.linalg.svd(corners - corners.mean(axis=0), full_matrices=False)
    if spread[-1] > _FLAT:
        return None
    offset = 0.5 * _THICKNESS * axes[-1]
    hull, _ = primitive(Shape("convex", tuple(np.concatenate([corners - offset, corners + offset]).ravel().tolist())))
    return hull


def _part_bounds(shape: coal.CollisionGeometry, placement: pin.SE3) -> FloatArray:
    """Return the box (2, 3) of one placed shape, from its support points along the axes."""
    if isinstance(shape, coal.Convex):
        points = np.array(shape.points()) @ placement.rotation.T + placement.translation
        return np.stack([points.min(axis=0), points.max(axis=0)])
    reach = _half_extent(shape, placement.rotation)
    return np.stack([placement.translation - reach, placement.translation + reach])


def _half_extent(shape: coal.CollisionGeometry, rotation: FloatArray) -> FloatArray:
    """Return the half size (n,) of a primitive along directions, the rows of `rotation` (n, 3) in its own frame."""
    if isinstance(shape, coal.Sphere):
        return np.full(len(rotation), shape.radius)
    if isinstance(shape, coal.Box):
        return np.abs(rotation) @ shape.halfSide
    along = np.abs(rotation[:, 2])
    if isinstance(shape, coal.Capsule):
        return along * shape.halfLength + shape.radius
    return along * shape.halfLength + shape.radius * np.sqrt(np.maximum(0.0, 1.0 - along**2))


Surface = tuple[FloatArray, NDArray[np.int64]]
"""Vertices (n, 3) [m] and vertex indices of triangles (m, 3)."""
_SIDES = 24  # of what is round


def mesh_surface(mesh: Path, scale: float = 1.0) -> Surface:
    """Return the surface of a mesh file.

    Raises:
        AssetNotFound: There is no such file.
        AssetInvalid: It is not a mesh.
    """
    if not mesh.is_file():
        raise AssetNotFound(mesh, "a shape")
    try:
        surface = coal.MeshLoader().load(str(mesh), np.full(3, scale))
    except (RuntimeError, ValueError) as error:
        raise AssetInvalid(mesh, f"no mesh: {error}") from error
    return np.array(surface.vertices()), _numbers([surface.tri_indices(k) for k in range(surface.num_tris)])


def shape_surface(shape: UrdfShape, scale: float = 1.0) -> Surface:
    """Return the surface of one shape of a URDF file in the frame of its link; round shapes become polyhedra."""
    if shape.mesh is not None:
        corners, triangles = mesh_surface(shape.mesh)
        return _moved(scale * np.array(shape.size) * corners, to_placement(shape.origin, scale)), triangles
    build = {"box": coal.Box, "sphere": coal.Sphere, "cylinder": coal.Cylinder, "capsule": coal.Capsule}.get(shape.kind)
    if build is None:
        raise AssetInvalid(Path(f"<{shape.kind}>"), "it is not a box, sphere, cylinder, capsule or mesh")
    return part_surface((build(*(scale * number for number in shape.size)), to_placement(shape.origin, scale)))


def part_surface(part: Part) -> Surface:
    """Return the surface of a solid in the frame of its link; round shapes become polyhedra."""
    solid, placement = part
    if not isinstance(solid, coal.Convex):
        solid, _ = primitive(Shape("convex", tuple(np.ravel(_corners(solid)).tolist())))
    return _moved(np.array(solid.points()), placement), _numbers([solid.polygons(k) for k in range(solid.num_polygons)])


def part_volume(part: Part) -> float:
    """Return the volume of a solid [m^3]."""
    return float(part[0].computeVolume())


def _corners(solid: coal.CollisionGeometry) -> FloatArray:
    """Return corners (n, 3) whose hull approximates a primitive."""
    if isinstance(solid, coal.Box):
        return np.array(list(product((-1.0, 1.0), repeat=3))) * solid.halfSide
    around = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    circle = np.stack([np.cos(around), np.sin(around), np.zeros(_SIDES)], axis=1)
    if isinstance(solid, coal.Cylinder):
        ring = solid.radius * circle
        return np.concatenate([ring + (0.0, 0.0, h) for h in (-solid.halfLength, solid.halfLength)])
    heights = np.linspace(-np.pi / 2, np.pi / 2, _SIDES // 2 + 1)
    rings = [np.cos(h) * circle + (0.0, 0.0, np.sin(h)) for h in heights[1:-1]]
    ball = solid.radius * np.concatenate([*rings, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
    if isinstance(solid, coal.Sphere):
        return ball
    return np.concatenate(
        [ball[ball[:, 2] >= 0] + (0.0, 0.0, solid.halfLength), ball[ball[:, 2] <= 0] - (0.0, 0.0, solid.halfLength)]
    )


def _moved(corners: FloatArray, placement: pin.SE3) -> FloatArray:
    moved: FloatArray = corners @ placement.rotation.T + placement.translation
    return moved


def _numbers(triangles: list[coal.Triangle]) -> NDArray[np.int64]:
    return np.array([[triangle[k] for k in range(3)] for triangle in triangles], dtype=np.int64).reshape(-1, 3)
