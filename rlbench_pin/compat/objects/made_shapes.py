"""Bodies that programs add to the world, and their model files.

The path of a model file depends only on its content and on the user.
"""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.compat.objects.elements import Element
from rlbench_pin.compat.objects.scene_objects import BodyObject, LinkObject, SceneObject
from rlbench_pin.compat.objects.table import ObjectTable
from rlbench_pin.environment.runtime import EmptyTable
from rlbench_pin.errors import AssetInvalid, RlbenchPinError
from rlbench_pin.robot import geometry
from rlbench_pin.scene.spec import WORLD, BodySpec
from rlbench_pin.spatial import FloatArray, pose_to_se3, relative
from rlbench_pin.urdf import read_urdf

_FRICTION = 0.8
_SIDES = 32  # number of segments of surfaces of revolution


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed surface in the frame of its shape."""

    vertices: FloatArray
    """Vertices (n, 3) [m]."""
    triangles: NDArray[np.int64]
    """Vertex indices (m, 3), counter-clockwise as seen from outside."""


def mesh_file(mesh: Mesh, mass: float) -> Path:
    """Write the model file of a surface and return its path; the collision shape is the convex hull."""
    text = "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in mesh.vertices)
    text += "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in mesh.triangles)
    stored = _store(text, ".obj")
    size = np.ptp(mesh.vertices, axis=0)
    return _write(f'<mesh filename="{stored.name}"/>', (float(size[0]), float(size[1]), float(size[2])), mass)


def _turned(profile: tuple[tuple[float, float], ...]) -> Mesh:
    """Return the closed surface of revolution of a profile of (radius, height) about the z-axis."""
    angles = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.stack([np.cos(angles), np.sin(angles), np.zeros(_SIDES)], axis=1)
    rings = [ring * (radius, radius, 0.0) + (0.0, 0.0, height) for radius, height in profile]
    ends = [[0.0, 0.0, profile[0][1]], [0.0, 0.0, profile[-1][1]]]
    triangles = []
    for level in range(len(profile) - 1):
        for k in range(_SIDES):
            a, b = level * _SIDES + k, level * _SIDES + (k + 1) % _SIDES
            triangles += [[a, b, b + _SIDES], [a, b + _SIDES, a + _SIDES]]
    bottom, top, last = len(profile) * _SIDES, len(profile) * _SIDES + 1, (len(profile) - 1) * _SIDES
    for k in range(_SIDES):
        following = (k + 1) % _SIDES
        triangles += [[bottom, following, k], [top, last + k, last + following]]
    return Mesh(np.concatenate([*rings, np.array(ends)]), np.array(triangles, dtype=np.int64))


def _write(geometry: str, size: tuple[float, float, float], mass: float) -> Path:
    """Write a URDF file with one link and return its path; the inertia is that of a box of the same size."""
    x, y, z = (s * s for s in size)
    ixx, iyy, izz = (mass / 12.0 * max(v, 1e-8) for v in (y + z, x + z, x + y))
    element = f"<geometry>{geometry}</geometry>"
    return _store(
        '<?xml version="1.0"?>\n<robot name="shape"><link name="shape">\n'
        f'<contact><lateral_friction value="{_FRICTION}"/></contact>\n'
        f'<inertial><mass value="{mass:.9g}"/>'
        f'<inertia ixx="{ixx:.9g}" ixy="0" ixz="0" iyy="{iyy:.9g}" iyz="0" izz="{izz:.9g}"/></inertial>\n'
        f'<visual>{element}<material name="shape"><color rgba="0.8 0.8 0.8 1"/></material></visual>\n'
        f"<collision>{element}</collision>\n</link></robot>\n",
        ".urdf",
    )


def _store(text: str, suffix: str) -> Path:
    """Write a text to a file whose name is a hash of the content, unless it exists, and return its path.

    Raises:
        RlbenchPinError: The folder for such files belongs to another user.
    """
    folder = Path(tempfile.gettempdir()) / f"rlbench_pin_shapes_{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    if folder.is_symlink() or folder.stat().st_uid != os.getuid():
        raise RlbenchPinError(f"'{folder}' belongs to another user. Set TMPDIR to your own folder.")
    file = folder / (hashlib.sha256(text.encode()).hexdigest()[:32] + suffix)
    if not file.is_file():
        handle, temporary = tempfile.mkstemp(dir=folder)
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            stream.write(text)
        Path(temporary).replace(file)
    return file


_NOT_IN_NAMES = re.compile("[^a-z0-9_]")
_MESH_MASS = 1.0  # [kg]


class InvalidShape(RlbenchPinError, ValueError):
    """The size, mass or mesh of a new shape is invalid."""


@dataclass(frozen=True)
class BodySettings:
    """Settings of a new body."""

    static: bool = False
    """Whether the body is fixed in the world."""
    respondable: bool = True
    """Whether the body collides with other objects."""
    color: tuple[float, ...] | None = None
    """RGB or RGBA from 0 to 1; None uses the colour of the model file."""


def primitive(kind: str, size: Sequence[float], mass: float) -> Path:
    """Return the model file of a primitive shape.

    Args:
        kind: `CUBOID`, `SPHERE`, `CYLINDER` or `CONE`.
        size: Lengths along x, y, z (3,) [m].
        mass: Mass [kg].

    Raises:
        InvalidShape: A length or the mass is not positive and finite.
    """
    lengths = [float(s) for s in size]
    if len(lengths) != 3 or not all(0.0 < s < float("inf") for s in lengths):
        raise InvalidShape(f"The lengths of a {kind.lower()} have to be three positive numbers [m], not {lengths}.")
    if not 0.0 < mass < float("inf"):
        raise InvalidShape(f"A mass has to be positive and finite, not {mass} kg. Use static=True for a body that does not move.")
    x, y, z = length = (lengths[0], lengths[1], lengths[2])
    round_about_z = abs(x - y) < 1e-9
    if kind == "CUBOID":
        return _write(f'<box size="{x:.9g} {y:.9g} {z:.9g}"/>', length, mass)
    if kind == "SPHERE" and round_about_z and abs(x - z) < 1e-9:
        return _write(f'<sphere radius="{x / 2:.9g}"/>', length, mass)
    if kind == "CYLINDER" and round_about_z:
        return _write(f'<cylinder radius="{x / 2:.9g}" length="{z:.9g}"/>', length, mass)
    profiles = {"CYLINDER": ((1.0, -1.0), (1.0, 1.0)), "CONE": ((1.0, -1.0), (0.0, 1.0))}
    angles = np.linspace(-np.pi / 2, np.pi / 2, _SIDES // 2 + 1)
    profile = profiles.get(kind, tuple((float(np.cos(a)), float(np.sin(a))) for a in angles))
    turned = _turned(profile)
    return mesh_file(Mesh(turned.vertices * (0.5 * np.array(length)), turned.triangles), mass)


def mesh(corners: FloatArray, triangles: NDArray[np.int64]) -> tuple[Path, FloatArray]:
    """Return the model file of a mesh, and the centre of its bounding box (3,) [m], which is the origin of the model.

    Args:
        corners: Vertices (n, 3) [m].
        triangles: Vertex indices (m, 3).

    Raises:
        InvalidShape: There are too few vertices or triangles, an index is out of range, or the mesh is flat.
    """
    if len(corners) < 4 or len(triangles) < 1 or not np.isfinite(corners).all():
        raise InvalidShape(f"A mesh needs at least 4 finite corners and a triangle, not {len(corners)} and {len(triangles)}.")
    if triangles.min() < 0 or triangles.max() >= len(corners):
        raise InvalidShape(
            f"The triangles refer to corners {triangles.min()} to {triangles.max()}, but there are only {len(corners)} corners."
        )
    if np.linalg.matrix_rank(corners - corners[0], tol=1e-7) < 3:
        raise InvalidShape("All corners of the mesh are in one plane, but a body needs a volume. Use a thin cuboid.")
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    return mesh_file(Mesh(corners - middle, triangles), _MESH_MASS), middle


def read_mesh(filename: str, scale: float) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return vertices (n, 3) [m] and triangles (m, 3) of a mesh file, scaled by `scale`."""
    file = Path(filename).expanduser().resolve()
    if file.suffix.lower() in (".ttm", ".ttt"):
        raise AssetInvalid(file, "it is a model of another simulator; export its shapes as obj or stl, and import those")
    return geometry.mesh_surface(file, scale)


def spawn(table: ObjectTable, name: str, asset: Path, settings: BodySettings) -> Element:
    """Add a body at the origin of the world, and return it.

    Args:
        table: Objects of the world.
        name: Name of the body; a number is appended if it is in use.
        asset: Model file.
        settings: Settings of the body.
    """
    shown = table.free_name(name)
    native = _free_native_name(table, f"made_{_NOT_IN_NAMES.sub('_', shown.lower())}")
    values = {"fixed": settings.static, "collides": settings.respondable, "color": settings.color}
    spec = BodySpec.model_validate({"name": native, "parent": WORLD, "asset": str(asset), **values})
    table.world.add_body(native, spec)
    element = Element("body", native)
    table.forget(element)
    table.rename(element, shown)
    if isinstance(table.runtime.task, EmptyTable):
        table.permanent.add(native)
    return element


def _free_native_name(table: ObjectTable, stem: str) -> str:
    """Return `stem`, with a number appended if the world has such a name."""
    world = table.world
    taken = {*world.bodies, *world.room, *world.frames, WORLD}
    names = (stem, *(f"{stem}{k}" for k in range(len(taken) + 1)))
    return next(n for n in names if n not in taken)


def duplicate(table: ObjectTable, element: Element) -> Element:
    """Add a copy of a body at the same pose, and return it."""
    body = table.world.body(element.name)
    specs = {spec.name: spec for spec in (*table.world.spec.body, *table.world.spawned.values())}
    made = spawn(table, table.name(element), body.model.urdf, BodySettings(body.fixed, body.collides))
    copy = table.world.body(made.name)
    if specs[element.name].scale != 1.0:
        table.world.remove_body(made.name)
        spec = specs[element.name].model_copy(update={"parent": WORLD, "asset": str(body.model.urdf)})
        copy = table.world.add_body(made.name, spec)
    for name, joint in body.joints.items():
        copy.joint(name).set_position(joint.position)
    copy.set_pose(body.pose)
    return made


def discard(table: ObjectTable, element: Element) -> None:
    """Remove an object that a program added; its children keep their poses.

    Raises:
        RlbenchPinError: The object belongs to the scene file.
    """
    if element.kind not in ("placed", "body") or (element.kind == "body" and element.name not in table.world.spawned):
        raise RlbenchPinError(
            f"'{table.name(element)}' belongs to the scene file. Move it away, or remove it from the scene file."
        )
    for child in table.children(element):
        if child.kind not in ("link", "joint"):
            table.set_parent(child, None)
    if element.kind == "placed":
        del table.placed[element.name]
    else:
        table.world.remove_body(element.name)


def surface(item: SceneObject) -> tuple[FloatArray, NDArray[np.int64], FloatArray]:
    """Return the visual surface of an object: vertices (n, 3) [m] in its frame, triangles (m, 3) and normals (3 m, 3).

    There is one normal for each vertex of each triangle. Primitives are convex hulls of their corners; meshes do not change.
    """
    corners: list[FloatArray] = []
    triangles: list[NDArray[np.int64]] = []
    for vertices, faces in _surfaces(item):
        triangles.append(faces + sum(len(c) for c in corners))
        corners.append(vertices)
    if not corners:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3))
    points, all_faces = np.concatenate(corners), np.concatenate(triangles)
    a, b, c = (points[all_faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return points, all_faces, np.repeat(normals, 3, axis=0)


def _surfaces(item: SceneObject) -> list[tuple[FloatArray, NDArray[np.int64]]]:
    """Return vertices and triangles of each visual shape; objects without visuals have their collision shapes."""
    if not isinstance(item, BodyObject | LinkObject):
        return [geometry.part_surface(part) for parts, _ in item.solids() for part in parts]
    links = item.body.links if isinstance(item, BodyObject) else (item.link,)
    visuals = {link.name: link.visuals for link in read_urdf(item.body.model.urdf).links}
    found = []
    for link in links:
        T_item_link = pose_to_se3(relative(item.body.link_pose(link), item.pose))
        for shape in visuals[link]:
            vertices, faces = geometry.shape_surface(shape, item.body.model.scale)
            found.append((vertices @ T_item_link.rotation.T + T_item_link.translation, faces))
    return found
