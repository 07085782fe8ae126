"""Shapes: bodies, their links, planes of a scene, and shapes that programs create."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from pyrep.const import PrimitiveShape, TextureMappingMode
from pyrep.errors import UnsupportedCall
from pyrep.objects.object import Numbers, Object
from rlbench_pin.compat.objects import Element, ObjectTable, made_shapes
from rlbench_pin.compat.objects import ObjectType as TypeName
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot import geometry
from rlbench_pin.sim import Body, read_texture
from rlbench_pin.spatial import FloatArray, compose, pose_at, pose_to_matrix
from rlbench_pin.urdf import UrdfOrigin, read_urdf

Rgba = tuple[float, ...]
ROBOT_SHAPES = ("robot", "gripper", "robot_link")
"""Kinds of elements that consist of links of the robot."""
WHITE: Rgba = (1.0, 1.0, 1.0, 1.0)


class Shape(Object):
    """A body of the scene, one of its links, a part of the room or of the arm, or a plane for random placement.

    Links of a body have the name `<body>/<link>`, or the name of the link if it is unique.

    A shape that a program creates in `init_task`, or before the first step, exists in every episode. A shape that is created
    during an episode is removed by the next reset. A shape that is created without a loaded task exists in every task.
    """

    kinds: ClassVar[tuple[TypeName, ...]] = ("shape",)

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
        """Add a primitive shape to the world; see `Shape` for its lifetime.

        * `type`: kind of primitive; `size`: lengths along x, y, z [m]; `mass` [kg].
        * `respondable`: collides with other objects; `static`: does not move; `renderable`: is visible in images.
        * `position` (3,) [m], None is the origin; `orientation`: Euler angles (3,) [rad].
        * `color`: RGB from 0 to 1, None is light grey.
        * All other arguments have no effect: both sides are drawn, edges are not.
        """
        kind = PrimitiveShape(type).name
        asset = made_shapes.primitive(kind, size, mass)
        settings = made_shapes.BodySettings(static, respondable, None if color is None else tuple(float(c) for c in color))
        shape = cls(made_shapes.spawn(Simulator.current().objects, kind.capitalize(), asset, settings))
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
        """Add a mesh to the world, at a fixed pose; see `Shape` for its lifetime.

        The origin is the centre of the bounding box. The collision shape is the convex hull.

        * `vertices`: x, y, z of all vertices [m] in one list, in world coordinates.
        * `indices`: vertex indices of all triangles in one list.
        * All other arguments have no effect.
        """
        corners = np.array(vertices, dtype=float).reshape(-1, 3)
        triangles = np.array(indices, dtype=np.int64).reshape(-1, 3)
        return cls._from_mesh(corners, triangles, "Mesh")

    @classmethod
    def import_mesh(cls, filename: str, scaling_factor: float = 1.0) -> Shape:
        """Add a mesh file (obj, stl, dae, ply) to the world, like `create_mesh`.

        Raises:
            AssetNotFound: There is no such file.
        """
        corners, triangles = made_shapes.read_mesh(filename, scaling_factor)
        return cls._from_mesh(corners, triangles, "Mesh")

    @classmethod
    def import_shape(
        cls, filename: str, scaling_factor: float = 1.0, ignore_color: bool = False, ignore_textures: bool = False
    ) -> Shape:
        """Add a mesh file without its materials and textures; see `import_mesh`."""
        return cls.import_mesh(filename, scaling_factor)

    @classmethod
    def _from_mesh(cls, corners: FloatArray, triangles: np.ndarray, name: str) -> Shape:
        """Add a mesh of vertices (n, 3) [m] in world coordinates and triangles (m, 3)."""
        asset, middle = made_shapes.mesh(corners, triangles)
        shape = cls(made_shapes.spawn(Simulator.current().objects, name, asset, made_shapes.BodySettings(static=True)))
        shape.set_position(middle)
        return shape

    def copy(self) -> Shape:
        """Add a copy of the body at the same pose."""
        element = self.element
        if element.kind != "body":
            raise UnsupportedCall(f"copy of '{self.get_name()}'", "it is not a whole body.", "Copy a whole body.")
        made = made_shapes.duplicate(self.table, element)
        shape = type(self)(made)
        shape.set_color(self.get_color())
        return shape

    def ungroup(self) -> list[Shape]:
        """Return the links of a body as separate shapes; their joints still connect them."""
        element = self.element
        if element.kind != "body":
            return [self]
        links = self.table.world.body(element.name).links[1:]
        return [self, *(Shape(f"{element.name}/{link}") for link in links)]

    def get_mesh_data(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the mesh in the frame of the shape: vertices (n, 3) [m], triangles (m, 3) and normals (3 m, 3).

        There is one normal for each vertex of each triangle.
        """
        return made_shapes.surface(self.scene_object)

    # Appearance ------------------------------------------------------------------------------------------------------

    def _get_rgba(self) -> Rgba:
        """Return the colour; for planes, which are not drawn, it is the last value of `_set_rgba`."""
        world, element, (owner, _, link) = self.table.world, self.element, self.element.name.partition("/")
        if element.kind in ("body", "room"):
            return world.body(element.name).color
        if element.kind == "link":
            body = world.body(owner)
            return body.colors.get(body.model.link_index(link), _file_color(body, link))
        if element.kind in ROBOT_SHAPES:
            return world.texture_overrides.robot_link_color(self._robot_links()[0])
        given = self.table.flags.get((element, "color"), WHITE)
        assert isinstance(given, tuple)
        return given

    def _set_rgba(self, rgba: Rgba) -> None:
        """Set the colour; for planes, which are not drawn, it is only stored."""
        world, element, (owner, _, link) = self.table.world, self.element, self.element.name.partition("/")
        if element.kind in ("body", "room"):
            world.body(element.name).set_color(rgba)
        elif element.kind == "link":
            world.body(owner).set_color(rgba, link)
        elif element.kind in ROBOT_SHAPES:
            red, green, blue, alpha = rgba
            for index in self._robot_links():
                world.texture_overrides.paint_robot_link(index, (red, green, blue, alpha))
        else:
            self.table.flags[element, "color"] = tuple(rgba)

    def _robot_links(self) -> list[int]:
        """Return the indices of the robot links that belong to the shape, those with visuals first."""
        world, gripper = self.table.world, self.table.runtime.model.fingers.links
        model = world.robot.model
        names = {"robot": tuple(model.links), "gripper": gripper}.get(self.element.kind, (self.element.name,))
        seen = world.texture_overrides.robot_links
        return sorted((model.link_index(name) for name in names), key=lambda index: index not in seen)

    def get_color(self) -> list[float]:
        """Return red, green, blue from 0 to 1."""
        return [float(c) for c in self._get_rgba()[:3]]

    def set_color(self, color: Any) -> None:
        """Set the colour of a body with all its links, or of one link.

        Args:
            color: Red, green, blue from 0 to 1.
        """
        values = [float(c) for c in color]
        self._set_rgba((*values[:3], self._get_rgba()[3]))

    def get_transparency(self) -> float:
        """Return the transparency: 0 is opaque, 1 is invisible."""
        return 1.0 - float(self._get_rgba()[3])

    def set_transparency(self, value: float) -> None:
        """Set the transparency: 0 is opaque, 1 is invisible; values in between are drawn opaque.

        Raises:
            ValueError: `value` is not between 0 and 1.
        """
        if not 0.0 <= value <= 1.0:
            raise ValueError(f"A transparency has to be between 0 (opaque) and 1 (invisible), not {value}.")
        self._set_rgba((*self._get_rgba()[:3], 1.0 - float(value)))

    def set_renderable(self, value: bool) -> None:
        """Set whether images show the shape; its colour does not change."""
        shown = bool(value)
        if shown == self.is_renderable():
            return
        self.set_flag("renderable", shown)
        if self.element.kind in ROBOT_SHAPES:
            for index in self._robot_links():
                self.table.world.texture_overrides.show_robot_link(index, shown)
            return
        rgba = self._get_rgba()
        if not shown:
            self.table.flags[self.element, "opacity"] = rgba[3]
        opacity = self.table.flags.get((self.element, "opacity"), 1.0)
        assert isinstance(opacity, float)
        self._set_rgba((*rgba[:3], opacity if shown else 0.0))

    def set_texture(
        self,
        texture: Any,
        mapping_mode: TextureMappingMode = TextureMappingMode.PLANE,
        interpolate: bool = True,
        decal_mode: bool = False,
        repeat_along_u: bool = False,
        repeat_along_v: bool = False,
        uv_scaling: list[float] | None = None,
        position: list[float] | None = None,
        orientation: list[float] | None = None,
    ) -> None:
        """Set the texture of a body, a part of the room or a link of the arm; no effect for planes, which are not drawn.

        * `texture`: from `PyRep.create_texture`.
        * `uv_scaling`: length of the image on the shape [m], two numbers of which the first counts; None is 1 m.
        * All other arguments have no effect: textures are mapped along the axes of the shape and repeat.
        """
        file = getattr(texture, "filename", None)
        if file is None:
            raise UnsupportedCall("set_texture", f"{texture!r} is not a texture.", "Make one with `PyRep.create_texture(file)`.")
        image, repeats = read_texture(file), 1.0 / float(uv_scaling[0]) if uv_scaling else 1.0
        overrides, kind, name = self.table.world.texture_overrides, self.element.kind, self.element.name
        if kind in ("body", "link"):
            overrides.set_body(name.partition("/")[0], image, repeats)
        elif kind == "room":
            overrides.set_room_body(name, image)
        elif kind in ROBOT_SHAPES:
            for index in set(self._robot_links()) & set(overrides.robot_links):
                overrides.set_robot_link(index, image, repeats)

    def get_texture(self) -> None:
        """Raise UnsupportedCall: the texture of a shape cannot be read."""
        raise UnsupportedCall("get_texture", "textures are not read back.", "Keep what `create_texture` returned.")

    def remove_texture(self) -> None:
        """Remove the texture, so that images show the colours of the shape."""
        overrides, kind, name = self.table.world.texture_overrides, self.element.kind, self.element.name
        if kind in ("body", "link"):
            overrides.clear_body(name.partition("/")[0])
        elif kind == "room":
            overrides.clear_room_body(name)
        elif kind in ROBOT_SHAPES:
            for index in self._robot_links():
                overrides.clear_robot_link(index)

    # Physics ---------------------------------------------------------------------------------------------------------

    def body(self, call: str) -> Body:
        """Return the body of the shape, or of its link.

        Raises:
            UnsupportedCall: The shape is a plane or a part of the arm; the message names `call`.
        """
        return body_of(self.table, self.element, call)

    def _has_body(self) -> bool:
        """Return whether the shape is a body, a link of a body, or a part of the room."""
        return self.element.kind in BODIES

    def _link_index(self) -> int:
        """Return the index of the link in the physics engine; -1 for the base link."""
        body, link = self.body("a physical property"), self.element.name.partition("/")[2]
        return body.model.link_index(link) if link else -1

    def is_respondable(self) -> bool:
        """Return whether the shape collides with other objects."""
        return self._has_body() and self.body("is_respondable").collides

    def set_respondable(self, value: bool) -> None:
        """Set whether the shape collides with other objects; for a link it applies to the whole body. Planes never collide."""
        if self._has_body() or value:
            self.body("set_respondable").set_collides(bool(value))

    def is_dynamic(self) -> bool:
        """Return whether the shape moves under gravity and contacts."""
        return self._has_body() and not self.body("is_dynamic").fixed

    def set_dynamic(self, value: bool) -> None:
        """Set whether the shape moves under gravity and contacts, or is fixed at its pose.

        Raises:
            UnsupportedCall: The shape is a part of the room, or a link.
            RlbenchPinError: The shape has joints, or no mass in its model file.
        """
        if not self._has_body() and not value:
            return
        body = self.body("set_dynamic")
        if bool(value) == (not body.fixed):
            return
        if self.element.kind != "body":
            raise UnsupportedCall(
                f"set_dynamic({bool(value)}) of '{self.get_name()}'",
                "it is part of something larger.",
                "Call it on a whole body.",
            )
        self.table.world.dynamics_overrides.set_fixed(body, not value)

    def get_mass(self) -> float:
        """Return the mass [kg] of the link; for a body that of the base link. Fixed bodies have a mass as well."""
        return self.table.world.dynamics_overrides.mass(self.body("get_mass").model, self._link_index())

    def set_mass(self, mass: float) -> None:
        """Set the mass [kg]; resets do not restore it."""
        if not 0.0 < mass < float("inf"):
            raise ValueError(f"A mass has to be positive and finite, not {mass} kg.")
        model = self.body("set_mass").model
        self.table.world.dynamics_overrides.set_mass(model, self._link_index(), float(mass))

    def get_bullet_friction(self) -> float:
        """Return the coefficient of sliding friction."""
        model = self.body("get_bullet_friction").model
        return self.table.world.dynamics_overrides.friction(model, self._link_index())

    def set_bullet_friction(self, friction: float) -> None:
        """Set the coefficient of sliding friction; resets do not restore it."""
        if not 0.0 <= friction < float("inf"):
            raise ValueError(f"A coefficient of friction has to be 0 or above, not {friction}.")
        model = self.body("set_bullet_friction").model
        self.table.world.dynamics_overrides.set_friction(model, self._link_index(), float(friction))

    def compute_mass_and_inertia(self, density: float) -> None:
        """Set the mass to a density [kg/m^3] times the volume of the collision shapes; the inertia changes in proportion.

        The volume of overlapping shapes counts twice.
        """
        parts = [part for parts, _ in self.scene_object.solids() for part in parts]
        self.set_mass(density * float(np.sum([geometry.part_volume(part) for part in parts])))

    def add_force(self, position: Numbers, force: Numbers, reset_force_torque: bool = False) -> None:
        """Apply the impulse of a force during one control tick at once; call it before each step for a constant force.

        Args:
            position: Point of action in the frame of the shape (3,) [m].
            force: Force in the frame of the shape (3,) [N].
            reset_force_torque: No effect: earlier forces have already been applied.
        """
        T_world_shape = self.get_matrix()
        at = T_world_shape @ np.append(_three(position), 1.0)
        self._push(T_world_shape[:3, :3] @ _three(force), np.zeros(3), at[:3])

    def add_force_and_torque(
        self, force: Numbers, torque: Numbers, reset_force: bool = False, reset_torque: bool = False
    ) -> None:
        """Apply a force at the centre of mass and a torque for one control tick, like `add_force`.

        Args:
            force: Force in the world (3,) [N].
            torque: Torque in the world (3,) [N m].
            reset_force: No effect: earlier forces have already been applied.
            reset_torque: No effect.
        """
        self._push(_three(force), _three(torque))

    def _push(self, force: FloatArray, torque: FloatArray, at: FloatArray | None = None) -> None:
        """Apply the impulse of a force and a torque during one control tick at once; a fixed body does not move.

        Args:
            force: Force in the world (3,) [N].
            torque: Torque in the world (3,) [N m].
            at: Point of action of the force in the world (3,) [m]; None is the centre of mass.

        Raises:
            UnsupportedCall: The shape is not a whole body.
        """
        body = self.body("a force")
        if self.element.kind != "body":
            raise UnsupportedCall(f"a force on '{self.get_name()}'", "it is part of something larger.", "Push a whole body.")
        if body.fixed:
            return
        T_world_com, per_kilogram = _centre_of_mass(body)
        R, kilograms = pose_to_matrix(T_world_com)[:3, :3], self.get_mass()
        turn = torque if at is None else torque + np.cross(at - T_world_com[:3], force)
        change = np.concatenate([force / kilograms, np.linalg.solve(kilograms * R @ per_kilogram @ R.T, turn)])
        body.set_velocity(body.velocity + self.table.world.control_dt * change)

    def set_velocity(self, linear: Any, angular: Any = (0.0, 0.0, 0.0)) -> None:
        """Set linear (3,) [m/s] and angular (3,) [rad/s] velocity in world axes."""
        self.body("set_velocity").set_velocity(np.concatenate([np.asarray(linear, float), np.asarray(angular, float)]))


BODIES = ("body", "link", "room")
"""Kinds of elements that are a body of the scene or of the room, or a link of a body."""


def body_of(table: ObjectTable, element: Element, call: str) -> Body:
    """Return the body of an element, or of its link.

    Raises:
        UnsupportedCall: The element has no body; the message names `call`.
    """
    if element.kind not in BODIES:
        raise UnsupportedCall(
            f"{call} of '{table.name(element)}'", "it is not a body of the scene.", "Call it on a body, or a link of one."
        )
    return table.world.body(element.name.partition("/")[0])


def _file_color(body: Body, link: str) -> Rgba:
    """Return the colour of the first visual of a link in its model file."""
    found = next(part for part in read_urdf(body.model.urdf).links if part.name == link)
    colors = [visual.color for visual in found.visuals if visual.color is not None]
    return colors[0] if colors else WHITE


def _centre_of_mass(body: Body) -> tuple[FloatArray, FloatArray]:
    """Return the inertial frame (7,) of the base link in the world, and its inertia (3, 3) divided by the mass [m^2]."""
    urdf, scale = read_urdf(body.model.urdf), body.model.scale
    inertial = next(link.inertial for link in urdf.links if link.name == urdf.base_link)
    if inertial is None:
        raise RlbenchPinError(
            f"{body.model.urdf.name} has no inertia for '{body.name}', so that no torque can act on it. "
            "Add <inertial> to the URDF."
        )
    xx, xy, xz, yy, yz, zz = inertial.inertia
    origin = inertial.origin or UrdfOrigin()
    place = compose(body.pose, pose_at([scale * x for x in origin.xyz], *origin.rpy))
    return place, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / inertial.mass


def _three(values: Numbers) -> FloatArray:
    """Return values as an array (3,), or raise ValueError if they are not three finite numbers."""
    numbers = np.asarray(values, dtype=float).reshape(-1)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise ValueError(f"A position, force or torque has to be 3 finite numbers, not {numbers.tolist()}.")
    return numbers
