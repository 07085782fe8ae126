"""Bodies that programs add to the world."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rlbench_pin.compat.things import shape_files
from rlbench_pin.compat.things.element import Element
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.compat.things.thing import BodyThing, LinkThing, Thing
from rlbench_pin.environment.runtime import EmptyTable
from rlbench_pin.errors import AssetInvalid, RlbenchPinError
from rlbench_pin.robot import geometry
from rlbench_pin.scene.spec import WORLD, BodySpec
from rlbench_pin.spatial import FloatArray, pose_to_se3, relative
from rlbench_pin.urdf import read_urdf

_NOT_IN_NAMES = re.compile("[^a-z0-9_]")
_MESH_MASS = 1.0  # [kg]


class InvalidShape(RlbenchPinError, ValueError):
    """Sizes or corners of which no shape can be made."""


@dataclass(frozen=True)
class Look:
    """How a new body is set up."""

    static: bool = False
    """Welded to its place."""
    respondable: bool = True
    """Touches other things."""
    color: tuple[float, ...] | None = None
    """rgb or rgba in 0..1; None takes the one of the model file."""


def primitive(kind: str, size: Sequence[float], mass: float) -> Path:
    """Return the model file of a primitive; sizes (3,) [m], mass [kg].

    Raises:
        InvalidShape: A size or the mass is not positive.
    """
    lengths = [float(s) for s in size]
    if len(lengths) != 3 or not all(0.0 < s < float("inf") for s in lengths):
        raise InvalidShape(f"A {kind.lower()} has three positive lengths [m], not {lengths}.")
    if not 0.0 < mass < float("inf"):
        raise InvalidShape(f"A mass is positive and finite, not {mass} kg. Use static=True for what is not to move.")
    return shape_files.primitive_file(kind, (lengths[0], lengths[1], lengths[2]), float(mass))


def mesh(corners: FloatArray, triangles: NDArray[np.int64]) -> tuple[Path, FloatArray]:
    """Return the model file of a surface, and where the middle of its box is (3,) [m].

    Args:
        corners: (n, 3) [m].
        triangles: Corner numbers (m, 3).

    Raises:
        InvalidShape: There are no triangles, or they name corners that do not exist.
    """
    if len(corners) < 4 or len(triangles) < 1 or not np.isfinite(corners).all():
        raise InvalidShape(f"A mesh needs at least 4 finite corners and a triangle, not {len(corners)} and {len(triangles)}.")
    if triangles.min() < 0 or triangles.max() >= len(corners):
        raise InvalidShape(f"The triangles name corners {triangles.min()} to {triangles.max()}; there are {len(corners)}.")
    if np.linalg.matrix_rank(corners - corners[0], tol=1e-7) < 3:
        raise InvalidShape("All corners of the mesh lie in one plane; a body needs a volume. Use a thin cuboid.")
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    return shape_files.mesh_file(shape_files.Mesh(corners - middle, triangles), _MESH_MASS), middle


def read_mesh(filename: str, scale: float) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return corners (n, 3) [m] and triangles (m, 3) of a mesh file."""
    file = Path(filename).expanduser().resolve()
    if file.suffix.lower() in (".ttm", ".ttt"):
        raise AssetInvalid(file, "it is a model of another simulator; export its shapes as obj or stl, and import those")
    return geometry.mesh_surface(file, scale)


def spawn(table: ObjectTable, name: str, asset: Path, look: Look) -> Element:
    """Add a body at the origin of the world, and return it.

    Args:
        table: Things of the world.
        name: How it is called; a number is put behind where that name is in use.
        asset: Model file.
        look: How it is set up.
    """
    shown = table.free_name(name)
    native = _free_native_name(table, f"made_{_NOT_IN_NAMES.sub('_', shown.lower())}")
    color = None if look.color is None else tuple(look.color)
    spec = BodySpec.model_validate(
        {
            "name": native,
            "parent": WORLD,
            "asset": str(asset),
            "fixed": look.static,
            "collides": look.respondable,
            "color": color,
        }
    )
    table.world.add_body(native, spec)
    element = Element("body", native)
    table.forget(element)
    table.rename(element, shown)
    if isinstance(table.runtime.task, EmptyTable):
        table.everlasting.add(native)
    return element


def _free_native_name(table: ObjectTable, stem: str) -> str:
    world = table.world
    taken = {*world.bodies, *world.room, *world.frames, WORLD}
    names = (stem, *(f"{stem}{k}" for k in range(len(taken) + 1)))
    return next(n for n in names if n not in taken)


def duplicate(table: ObjectTable, element: Element) -> Element:
    """Add another body like one that exists, at the same pose, and return it."""
    body = table.world.body(element.name)
    specs = {spec.name: spec for spec in (*table.world.spec.body, *table.world.spawned.values())}
    made = spawn(table, table.name(element), body.model.urdf, Look(body.fixed, body.collides))
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
    """Take what a program made out of the scene; what hangs on it stays where it is.

    Raises:
        RlbenchPinError: It belongs to the scene file.
    """
    if element.kind not in ("placed", "body") or (element.kind == "body" and element.name not in table.world.spawned):
        raise RlbenchPinError(
            f"'{table.name(element)}' belongs to the scene file. Move it out of sight, or leave it out of the scene file."
        )
    for child in table.children(element):
        if child.kind not in ("link", "joint"):
            table.set_parent(child, None)
    if element.kind == "placed":
        del table.placed[element.name]
    else:
        table.world.remove_body(element.name)


def surface(thing: Thing) -> tuple[FloatArray, NDArray[np.int64], FloatArray]:
    """Return corners (n, 3) [m] in the frame of a thing, triangles (m, 3) and a normal for each corner of each (3 m, 3).

    Visual meshes are taken as they are; primitives as their corners' hull.
    """
    corners: list[FloatArray] = []
    triangles: list[NDArray[np.int64]] = []
    for vertices, faces in _surfaces(thing):
        triangles.append(faces + sum(len(c) for c in corners))
        corners.append(vertices)
    if not corners:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3))
    points, all_faces = np.concatenate(corners), np.concatenate(triangles)
    a, b, c = (points[all_faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return points, all_faces, np.repeat(normals, 3, axis=0)


def _surfaces(thing: Thing) -> list[tuple[FloatArray, NDArray[np.int64]]]:
    if not isinstance(thing, BodyThing | LinkThing):
        return [geometry.part_surface(part) for parts, _ in thing.solids() for part in parts]
    links = thing.body.links if isinstance(thing, BodyThing) else (thing.link,)
    visuals = {link.name: link.visuals for link in read_urdf(thing.body.model.urdf).links}
    found = []
    for link in links:
        T_thing_link = pose_to_se3(relative(thing.body.link_pose(link), thing.pose))
        for shape in visuals[link]:
            vertices, faces = geometry.shape_surface(shape, thing.body.model.scale)
            found.append((vertices @ T_thing_link.rotation.T + T_thing_link.translation, faces))
    return found
