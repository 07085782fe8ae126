"""Shapes: bodies, their links, planes of a scene, and what programs make."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from pyrep.const import PrimitiveShape
from pyrep.errors import UnsupportedCall
from pyrep.objects.object import Object
from pyrep.objects.shape_look import ShapeLook
from pyrep.objects.shape_physics import ShapePhysics
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.compat.things import ObjectType, shape_making
from rlbench_pin.spatial import FloatArray


class Shape(ShapeLook, ShapePhysics, Object):
    """A body of the scene, one of its links, a part of the room or of the arm, or a plane to place things on.

    A body with several links goes by its own name for the whole, and its links by `<body>/<link>`, or by the link's name alone
    where only one body has it.

    What a program makes in `init_task`, or before the first step, is there in every episode; what it makes during an episode is
    gone after the next reset, as a reset goes back to how the task was set up. What it makes while no task is loaded is there in
    every task, too.
    """

    kinds: ClassVar[tuple[ObjectType, ...]] = ("shape",)

    @classmethod
    def create(
        cls,
        type: PrimitiveShape,
        size: Sequence[float],
        mass: float = 1.0,
        backface_culling: bool = False,
        visible_edges: bool = False,
        smooth: bool = False,
        respondable: bool = True,
        static: bool = False,
        renderable: bool = True,
        position: Sequence[float] | None = None,
        orientation: Sequence[float] | None = None,
        color: Sequence[float] | None = None,
    ) -> Shape:
        """Add a primitive to the running world; how long it stays is told by `Shape`.

        * `type`: which solid; `size`: its lengths along x, y, z [m]; `mass` [kg].
        * `respondable`: touches other things; `static`: stays where it is put; `renderable`: cameras see it.
        * `position` (3,) [m], None is the origin; `orientation`: Euler angles (3,) [rad].
        * `color`: rgb in 0..1, None is light grey.
        * The rest is accepted: both sides are drawn, edges are not.
        """
        kind = PrimitiveShape(type).name
        asset = shape_making.primitive(kind, size, mass)
        look = shape_making.Look(static, respondable, None if color is None else tuple(float(c) for c in color))
        shape = cls(shape_making.spawn(Simulator.current().objects, kind.capitalize(), asset, look))
        shape.set_place(position, orientation)
        if not renderable:
            shape.set_renderable(False)
        return shape

    @classmethod
    def create_mesh(
        cls,
        vertices: Sequence[float],
        indices: Sequence[int],
        shading_angle: float | None = None,
        backface_culling: bool = False,
        visible_edges: bool = False,
    ) -> Shape:
        """Add a surface to the running world, welded to its place; how long it stays is told by `Shape`.

        Its frame is in the middle of its box. Others touch its convex hull.

        Args:
            vertices: x, y, z of all corners [m], one after the other, in world coordinates.
            indices: Corner numbers of all triangles.
            shading_angle: Accepted.
            backface_culling: Accepted.
            visible_edges: Accepted.
        """
        corners = np.array(vertices, dtype=float).reshape(-1, 3)
        triangles = np.array(indices, dtype=np.int64).reshape(-1, 3)
        return cls._from_mesh(corners, triangles, "Mesh")

    @classmethod
    def import_mesh(cls, filename: str, scaling_factor: float = 1.0) -> Shape:
        """Add the surface of a mesh file (obj, stl, dae, ply), as `create_mesh` does.

        Raises:
            AssetNotFound: There is no such file.
        """
        corners, triangles = shape_making.read_mesh(filename, scaling_factor)
        return cls._from_mesh(corners, triangles, "Mesh")

    @classmethod
    def import_shape(
        cls, filename: str, scaling_factor: float = 1.0, ignore_color: bool = False, ignore_textures: bool = False
    ) -> Shape:
        """Add the surface of a mesh file; its materials and textures are left out. See `import_mesh`."""
        return cls.import_mesh(filename, scaling_factor)

    @classmethod
    def _from_mesh(cls, corners: FloatArray, triangles: np.ndarray, name: str) -> Shape:
        asset, middle = shape_making.mesh(corners, triangles)
        shape = cls(shape_making.spawn(Simulator.current().objects, name, asset, shape_making.Look(static=True)))
        shape.set_position(middle)
        return shape

    def copy(self) -> Shape:
        """Add another body like it, at the same place."""
        element = self.element
        if element.kind != "body":
            raise UnsupportedCall(f"copy of '{self.get_name()}'", "it is no body of its own.", "Copy a whole body.")
        made = shape_making.duplicate(self.table, element)
        shape = type(self)(made)
        shape.set_color(self.get_color())
        return shape

    def ungroup(self) -> list[Shape]:
        """Return the links of a body as shapes of their own; they stay joined by their joints."""
        element = self.element
        if element.kind != "body":
            return [self]
        links = self.table.world.body(element.name).links[1:]
        return [self, *(Shape(f"{element.name}/{link}") for link in links)]

    def get_mesh_data(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return corners (n, 3) [m] in its own frame, triangles (m, 3) and a normal for each corner of each of them (3 m, 3)."""
        return shape_making.surface(self.thing)
