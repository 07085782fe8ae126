"""Surfaces of solids and mesh files as plain arrays: corners and triangles."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from rlbench_pin.errors import AssetInvalid, AssetNotFound
from rlbench_pin.robot import geometry
from rlbench_pin.scene.snapshot import Shape
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import UrdfShape

Surface = tuple[FloatArray, NDArray[np.int64]]
"""Corners (n, 3) [m] and corner numbers of triangles (m, 3)."""
_SIDES = 24  # of what is round


def mesh_surface(mesh: Path, scale: float = 1.0) -> Surface:
    """Return the surface of a mesh file, as it stands there.

    Raises:
        AssetNotFound: There is no such file.
        AssetInvalid: It is no mesh.
    """
    if not mesh.is_file():
        raise AssetNotFound(mesh, "a shape")
    try:
        surface = coal.MeshLoader().load(str(mesh), np.full(3, scale))
    except (RuntimeError, ValueError) as error:
        raise AssetInvalid(mesh, f"no mesh: {error}") from error
    return np.array(surface.vertices()), _numbers([surface.tri_indices(k) for k in range(surface.num_tris)])


def shape_surface(shape: UrdfShape, scale: float = 1.0) -> Surface:
    """Return the surface of one shape of a URDF file in the frame of its link; round ones become polyhedra."""
    if shape.mesh is not None:
        corners, triangles = mesh_surface(shape.mesh)
        return _moved(scale * np.array(shape.size) * corners, geometry.to_placement(shape.origin, scale)), triangles
    build = {"box": coal.Box, "sphere": coal.Sphere, "cylinder": coal.Cylinder, "capsule": coal.Capsule}.get(shape.kind)
    if build is None:
        raise AssetInvalid(Path(f"<{shape.kind}>"), "it is no box, sphere, cylinder, capsule or mesh")
    return part_surface((build(*(scale * number for number in shape.size)), geometry.to_placement(shape.origin, scale)))


def part_surface(part: geometry.Part) -> Surface:
    """Return the surface of a solid in the frame of its link; round ones become polyhedra."""
    solid, placement = part
    if not isinstance(solid, coal.Convex):
        solid, _ = geometry.primitive(Shape("convex", tuple(np.ravel(_corners(solid)).tolist())))
    return _moved(np.array(solid.points()), placement), _numbers([solid.polygons(k) for k in range(solid.num_polygons)])


def part_volume(part: geometry.Part) -> float:
    """Return the volume of a solid [m^3]."""
    return float(part[0].computeVolume())


def _corners(solid: coal.CollisionGeometry) -> FloatArray:
    """Return corners (n, 3) whose hull stands for a primitive."""
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
