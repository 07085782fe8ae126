"""Base class of scene objects: names, parents, poses, bounding boxes, contacts and flags."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

import numpy as np

from pyrep.const import ObjectType
from pyrep.errors import ObjectAlreadyRemovedError, PyRepError, UnsupportedCall, WrongObjectTypeError
from rlbench_pin.compat.joints import ConfigurationTree
from rlbench_pin.compat.objects import Element, ObjectTable, SceneObject, UnknownObject, made_shapes
from rlbench_pin.compat.objects import ObjectType as TypeName
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot import geometry
from rlbench_pin.spatial import FloatArray, compose, matrix_to_pose, pose_to_matrix, pose_to_se3, relative

Numbers = Sequence[float] | FloatArray
_OWNERS = {"link": "body", "robot_link": "robot", "gripper": "robot", "tip": "robot", "robot_joint": "robot"}


class InvalidPlace(RlbenchPinError, ValueError):
    """A pose is invalid: wrong number of values, NaN, or a quaternion whose length is not 1."""


class Object:
    """A view of one object of the scene; it stores only the identity, and finds the object at each call.

    Args:
        name_or_handle: Name or handle of the object.

    Raises:
        UnknownObject: There is no such object (also a RuntimeError).
        WrongObjectTypeError: The object has another type.
    """

    kinds: ClassVar[tuple[TypeName, ...]] = ()
    """Object types for which the class can be used; empty for any type."""

    def __init__(self, name_or_handle: str | int | Element) -> None:
        self._removed = False
        if isinstance(name_or_handle, Element):
            self._element = name_or_handle
        elif isinstance(name_or_handle, str):
            self._element = self.table.find(name_or_handle, self.kinds)
        else:
            self._element = self.table.of_handle(int(name_or_handle))
        found = self.table.scene_object(self._element).type
        if self.kinds and found not in self.kinds:
            raise WrongObjectTypeError(f"'{name_or_handle}' is a {found}, not a {type(self).__name__}. Use `Object.get_object`.")

    # Identity --------------------------------------------------------------------------------------------------------

    @property
    def table(self) -> ObjectTable:
        """Table of all objects of the current world."""
        return Simulator.current().objects

    @property
    def element(self) -> Element:
        """Identity of the object in the world.

        Raises:
            ObjectAlreadyRemovedError: `remove()` was called.
        """
        if self._removed:
            raise ObjectAlreadyRemovedError(f"'{self._element.name}' was removed. Create or look up another object.")
        return self._element

    @property
    def scene_object(self) -> SceneObject:
        """Access to the object in the current world."""
        return self.table.scene_object(self.element)

    @property
    def _handle(self) -> int:
        return self.get_handle()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Object) and self.identity() == other.identity()

    def __hash__(self) -> int:
        return hash(self._element)

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self._element.name}')"

    def identity(self) -> Element:
        """Return the identity for comparisons; available after `remove()` as well."""
        return self._element

    @staticmethod
    def exists(name: str) -> bool:
        """Return whether the scene has an object with a name."""
        try:
            Simulator.current().objects.find(name)
        except UnknownObject:
            return False
        return True

    @staticmethod
    def get_object_type(name: str) -> ObjectType:
        """Return the type of the object with a name."""
        table = Simulator.current().objects
        return ObjectType[table.scene_object(table.find(name)).type.upper()]

    @staticmethod
    def get_object_name(name_or_handle: str | int) -> str:
        """Return the name of the object with a name or handle."""
        table = Simulator.current().objects
        return table.name(table.find(name_or_handle) if isinstance(name_or_handle, str) else table.of_handle(name_or_handle))

    def get_type(self) -> ObjectType:
        """Return the type of this object."""
        return ObjectType[self.scene_object.type.upper()]

    def get_handle(self) -> int:
        """Return the handle; for objects in masks it is their number in masks."""
        return self.table.handle(self.element)

    def still_exists(self) -> bool:
        """Return whether the object is part of the scene."""
        return not self._removed and self.table.exists(self._element)

    def get_name(self) -> str:
        """Return the name."""
        return self.table.name(self.element)

    def set_name(self, name: str) -> None:
        """Rename the object; its previous name is no longer valid."""
        self.table.rename(self.element, name)

    # Parents and children --------------------------------------------------------------------------------------------

    @staticmethod
    def get_object(name_or_handle: str | int) -> Object:
        """Return the object with a name or handle, as an instance of the class for its type."""
        table = Simulator.current().objects
        element = table.find(name_or_handle) if isinstance(name_or_handle, str) else table.of_handle(int(name_or_handle))
        return view_of(element)

    def get_parent(self) -> Object | None:
        """Return the parent; None for the world."""
        parent = self.table.parent(self.element)
        return None if parent is None else view_of(parent)

    def set_parent(self, parent_object: Object | None, keep_in_place: bool = True) -> None:
        """Attach the object to a new parent, with which it then moves.

        Args:
            parent_object: The new parent; None is the world.
            keep_in_place: Keep the pose in the world; otherwise keep the pose relative to the parent.
        """
        parent = None if parent_object is None else parent_object.element
        self.table.set_parent(self.element, parent, keep_in_place)

    def get_objects_in_tree(
        self, object_type: ObjectType = ObjectType.ALL, exclude_base: bool = True, first_generation_only: bool = False
    ) -> list[Object]:
        """Return the descendants.

        Args:
            object_type: Return only objects of this type.
            exclude_base: Leave out this object.
            first_generation_only: Return only direct children.
        """
        table = self.table
        tree = table.tree(self.element, 1 if first_generation_only else -1)
        return views_of(tree if exclude_base else [self.element, *tree], object_type)

    # Poses -----------------------------------------------------------------------------------------------------------

    def get_pose(self, relative_to: Object | None = None) -> FloatArray:
        """Return the pose (7,): x, y, z [m], qx, qy, qz, qw.

        Args:
            relative_to: Object of the reference frame; None is the world.
        """
        pose = self.scene_object.pose
        return pose if relative_to is None else relative(pose, relative_to.get_pose())

    def set_pose(self, pose: Numbers, relative_to: Object | None = None, reset_dynamics: bool = True) -> None:
        """Move to a pose (7,).

        Args:
            pose: x, y, z [m], qx, qy, qz, qw.
            relative_to: Object of the reference frame; None is the world.
            reset_dynamics: Set the velocity to 0.
        """
        numbers = _numbers(pose, 7, "pose")
        norm = float(np.linalg.norm(numbers[3:]))
        if abs(norm - 1.0) > 1e-2:
            raise InvalidPlace(f"The quaternion {numbers[3:].tolist()} has length {norm:.4f}, not 1. The order is x, y, z, w.")
        numbers[3:] /= norm
        there = numbers if relative_to is None else compose(relative_to.get_pose(), numbers)
        self.scene_object.set_pose(there, reset_dynamics)

    def get_position(self, relative_to: Object | None = None) -> FloatArray:
        """Return the position (3,) [m]."""
        return self.get_pose(relative_to)[:3]

    def set_position(self, position: Numbers, relative_to: Object | None = None, reset_dynamics: bool = True) -> None:
        """Move to a position (3,) [m]; the orientation does not change."""
        pose = np.concatenate([_numbers(position, 3, "position"), self.get_pose(relative_to)[3:]])
        self.set_pose(pose, relative_to, reset_dynamics)

    def get_quaternion(self, relative_to: Object | None = None) -> FloatArray:
        """Return the orientation (4,): qx, qy, qz, qw."""
        return self.get_pose(relative_to)[3:]

    def set_quaternion(self, quaternion: Numbers, relative_to: Object | None = None, reset_dynamics: bool = True) -> None:
        """Rotate to an orientation (4,): qx, qy, qz, qw; the position does not change."""
        pose = np.concatenate([self.get_pose(relative_to)[:3], _numbers(quaternion, 4, "quaternion")])
        self.set_pose(pose, relative_to, reset_dynamics)

    def get_orientation(self, relative_to: Object | None = None) -> FloatArray:
        """Return Euler angles (3,) [rad] with R = Rx(a) Ry(b) Rz(c)."""
        return matrix_to_euler(self.get_matrix(relative_to)[:3, :3])

    def set_orientation(self, orientation: Numbers, relative_to: Object | None = None, reset_dynamics: bool = True) -> None:
        """Rotate to Euler angles (3,) [rad] with R = Rx(a) Ry(b) Rz(c); the position does not change."""
        self.set_quaternion(euler_to_quaternion(_numbers(orientation, 3, "orientation")), relative_to, reset_dynamics)

    def get_matrix(self, relative_to: Object | None = None) -> FloatArray:
        """Return the homogeneous matrix (4, 4) from the frame of the object to the world or to `relative_to`."""
        return pose_to_matrix(self.get_pose(relative_to))

    def set_matrix(self, matrix: FloatArray, relative_to: Object | None = None, reset_dynamics: bool = True) -> None:
        """Move to the pose of a homogeneous matrix (4, 4), or of its first three rows."""
        full = np.eye(4)
        numbers = np.asarray(matrix, dtype=float)
        if numbers.size not in (12, 16) or not np.isfinite(numbers).all():
            raise InvalidPlace(f"A matrix has to have shape (4, 4) or (3, 4) and finite numbers, not shape {numbers.shape}.")
        full[:3] = numbers.reshape(-1, 4)[:3]
        self.set_pose(matrix_to_pose(full), relative_to, reset_dynamics)

    def rotate(self, rotation: Numbers) -> None:
        """Rotate by angles (3,) [rad] about the x-axis, then y-axis, then z-axis of the object before the rotation."""
        a, b, c = _numbers(rotation, 3, "rotation")
        turn = np.eye(4)
        turn[:3, :3] = euler_to_matrix((0.0, 0.0, c)) @ euler_to_matrix((0.0, b, 0.0)) @ euler_to_matrix((a, 0.0, 0.0))
        self.set_pose(compose(self.get_pose(), matrix_to_pose(turn)))

    def set_place(self, position: Numbers | None, orientation: Numbers | None) -> None:
        """Set position (3,) [m] and Euler angles (3,) [rad]; None leaves a value unchanged."""
        if position is not None:
            self.set_position(position)
        if orientation is not None:
            self.set_orientation(orientation)

    def reset_dynamic_object(self) -> None:
        """Set the velocity to 0; the pose does not change."""
        self.set_pose(self.get_pose())

    # Boxes, contact, distance ----------------------------------------------------------------------------------------

    def get_bounding_box(self) -> list[float]:
        """Return x min, x max, y min, y max, z min, z max [m] of the box in the frame of the object, without descendants."""
        return [float(v) for v in self.scene_object.box().T.ravel()]

    def get_model_bounding_box(self) -> list[float]:
        """Return the bounding box like `get_bounding_box`, with descendants."""
        table, root = self.table, self.scene_object
        boxes = [root.box()]
        for member in table.tree(self.element):
            below = table.scene_object(member)
            if below.type == "shape":
                corners = geometry.box_corners(below.box(), relative(below.pose, root.pose))
                boxes.append(np.stack([corners.min(axis=0), corners.max(axis=0)]))
        solid = [box for box in boxes if np.any(box[1] > box[0])] or boxes
        lowest, highest = np.min([box[0] for box in solid], axis=0), np.max([box[1] for box in solid], axis=0)
        return [float(v) for v in np.stack([lowest, highest]).T.ravel()]

    def check_collision(self, obj: Object | None = None) -> bool:
        """Return whether the object touches `obj`; for None, whether it touches any collidable object outside its tree."""
        table, element = self.table, self.element
        if not self.is_collidable():
            return False
        own = {element, *table.ancestors(element), *table.tree(element)}
        obstacles = [e for e in table.elements() if e.kind in ("body", "room", "robot") and e not in own]
        others = obstacles if obj is None else [obj.element]
        return any(_touch(table, element, other) for other in others if table.flags.get((other, "collidable"), True))

    def check_distance(self, other: Object) -> float:
        """Return the smallest distance to another object [m]; 0 if they touch."""
        first, second = (o.scene_object.solids() or [((point_part(),), o.scene_object.pose)] for o in (self, other))
        return min(
            geometry.gap(parts, pose_to_se3(pose), others, pose_to_se3(there))
            for parts, pose in first
            for others, there in second
        )

    def get_contact(self, contact_obj: Object | None = None, get_contact_normal: bool = True) -> list[dict[str, Any]]:
        """Return the contact points of the last physics step.

        Args:
            contact_obj: The other object; None is any object.
            get_contact_normal: No effect: normals are always returned.

        Returns:
            One dict for each point, with `contact_handles` (2 numbers) and `contact` (6,): position [m], normal force [N].
        """
        table, element, other = self.table, self.element, None if contact_obj is None else contact_obj.element
        if element.kind in ("frame", "root", "placed", "camera") or (other is not None and other.kind in ("frame", "placed")):
            return []
        body, link = _body_and_link(table, element)
        second, second_link = (None, None) if other is None else _body_and_link(table, other)
        found = [c for c in table.world.contacts(body, second) if link in (None, c.link) and second_link in (None, c.other_link)]
        return [
            {
                "contact_handles": [_link_handle(table, c.body, c.link), _link_handle(table, c.other, c.other_link)],
                "contact": np.concatenate([c.position, c.force * np.asarray(c.normal)]),
            }
            for c in found
        ]

    def get_velocity(self) -> tuple[np.ndarray, np.ndarray]:
        """Return linear (3,) [m/s] and angular (3,) [rad/s] velocity in world axes."""
        velocity = self.scene_object.velocity
        return velocity[:3], velocity[3:]

    def get_configuration_tree(self) -> ConfigurationTree:
        """Return the poses and joint positions of the object and its descendants, for `PyRep.set_configuration_tree`."""
        return ConfigurationTree.read(self.table, self.element)

    # Flags -----------------------------------------------------------------------------------------------------------

    def flag(self, name: str, default: bool = True) -> bool:
        """Return the value of a flag."""
        return bool(self.table.flags.get((self.element, name), default))

    def set_flag(self, name: str, value: bool, model: bool = False) -> None:
        """Set a flag of the object; with `model` also of its descendants."""
        tree = self.table.tree(self.element) if model else []
        for element in (self.element, *tree):
            self.table.flags[element, name] = bool(value)
            if name == "collidable" and element.kind in ("body", "room"):
                self.table.world.body(element.name).obstacle = bool(value)

    def is_collidable(self) -> bool:
        """Return whether collision checks and plans include the object."""
        return self.flag("collidable")

    def set_collidable(self, value: bool) -> None:
        """Set whether collision checks and plans include the object; physics does not change (see `Shape.set_respondable`)."""
        self.set_flag("collidable", value)

    def is_measurable(self) -> bool:
        """Return whether distances to the object are measured."""
        return self.flag("measurable")

    def set_measurable(self, value: bool) -> None:
        """Set whether distances to the object are measured."""
        self.set_flag("measurable", value)

    def is_detectable(self) -> bool:
        """Return whether proximity sensors detect the object."""
        return self.flag("detectable")

    def set_detectable(self, value: bool) -> None:
        """Set whether proximity sensors detect the object."""
        self.set_flag("detectable", value)

    def is_renderable(self) -> bool:
        """Return whether images show the object."""
        return self.flag("renderable")

    def set_renderable(self, value: bool) -> None:
        """Set whether images show the object; it has an effect for shapes only."""
        self.set_flag("renderable", value)

    def is_model_collidable(self) -> bool:
        """Return whether collision checks include the object and its descendants."""
        return self._all("collidable")

    def set_model_collidable(self, value: bool) -> None:
        """Set whether collision checks include the object and its descendants."""
        self.set_flag("collidable", value, model=True)

    def is_model_measurable(self) -> bool:
        """Return whether distances to the object and its descendants are measured."""
        return self._all("measurable")

    def set_model_measurable(self, value: bool) -> None:
        """Set whether distances to the object and its descendants are measured."""
        self.set_flag("measurable", value, model=True)

    def is_model_detectable(self) -> bool:
        """Return whether proximity sensors detect the object and its descendants."""
        return self._all("detectable")

    def set_model_detectable(self, value: bool) -> None:
        """Set whether proximity sensors detect the object and its descendants."""
        self.set_flag("detectable", value, model=True)

    def is_model_renderable(self) -> bool:
        """Return whether images show the object and its descendants."""
        return self._all("renderable")

    def _all(self, name: str) -> bool:
        tree = self.table.tree(self.element)
        return all(bool(self.table.flags.get((element, name), True)) for element in (self.element, *tree))

    # Models ----------------------------------------------------------------------------------------------------------

    def is_model(self) -> bool:
        """Return the value of `set_model`; by default whether the object has children."""
        return self.flag("model", default=bool(self.table.children(self.element)))

    def set_model(self, value: bool) -> None:
        """Set the value of `is_model`; nothing else depends on it."""
        self.set_flag("model", value)

    def set_model_renderable(self, value: bool) -> None:
        """Set whether images show the object and its descendants."""
        for member in self.get_objects_in_tree(exclude_base=False):
            member.set_renderable(value)

    def is_respondable(self) -> bool:
        """Return False: only shapes collide with other objects."""
        return False

    def set_respondable(self, value: bool) -> None:
        """Set a flag without other effect: only shapes collide with other objects."""
        self.set_flag("respondable", value)

    def is_dynamic(self) -> bool:
        """Return False: physics moves only shapes."""
        return False

    def is_model_respondable(self) -> bool:
        """Return whether all shapes of the object and its descendants collide with other objects."""
        return all(shape.is_respondable() for shape in self.get_objects_in_tree(ObjectType.SHAPE, exclude_base=False))

    def set_model_respondable(self, value: bool) -> None:
        """Set whether the shapes of the object and its descendants collide with other objects."""
        for shape in self.get_objects_in_tree(ObjectType.SHAPE, exclude_base=False):
            shape.set_respondable(value)

    def is_model_dynamic(self) -> bool:
        """Return whether physics moves all shapes of the object and its descendants."""
        return all(shape.is_dynamic() for shape in self.get_objects_in_tree(ObjectType.SHAPE, exclude_base=False))

    def get_explicit_handling(self) -> int:
        """Return 1: all sensors are read on request."""
        return 1

    def set_explicit_handling(self, value: int) -> None:
        """No effect: all sensors are read on request."""

    def get_extension_string(self) -> str:
        """Return the extension string of a waypoint of a scene file; empty for other objects."""
        found = [w for w in self.table.world.spec.waypoint if self.element == Element("frame", w.name)]
        if not found:
            return ""
        waypoint = found[0]
        words = ["ignore_collision"] if waypoint.ignore_collisions else []
        words += ["linear"] if waypoint.path == "straight" else []
        if waypoint.gripper in ("open", "close"):
            words.append(f"{waypoint.gripper}_gripper()")
        elif waypoint.gripper is not None:
            words.append(f"open_gripper({waypoint.gripper})")
        return ";".join(words)

    def scale_object(self, scale_x: float, scale_y: float, scale_z: float) -> None:
        """Raise UnsupportedCall: sizes are part of the model."""
        raise UnsupportedCall(
            "scale_object", "sizes are part of the model file.", "Use `scale` in the scene file, or `Shape.create`."
        )

    def save_model(self, path: str) -> None:
        """Raise UnsupportedCall: ttm files are not supported."""
        raise UnsupportedCall("save_model", "ttm files are not supported.", "Scenes are TOML files and models URDF files.")

    def copy(self) -> Object:
        """Raise UnsupportedCall; classes whose objects can be copied override this."""
        raise UnsupportedCall(f"copy of '{self.get_name()}'", "it is part of the fixed scene.", "Copy a Shape or a Dummy.")

    def remove(self) -> None:
        """Remove the object from the scene; its children keep their poses.

        Raises:
            PyRepError: The object belongs to the scene file; only objects that a program created can be removed.
        """
        try:
            made_shapes.discard(self.table, self.element)
        except RlbenchPinError as error:
            raise PyRepError(str(error)) from error
        self._removed = True


def view_of(element: Element) -> Object:
    """Return a view of an element, as an instance of the class for its type."""
    found = Simulator.current().objects.scene_object(element).type
    classes = [c for c in _classes(Object) if c.kinds[:1] == (found,)]
    return (classes or [Object])[0](element)


def _classes(base: type[Object]) -> list[type[Object]]:
    """Return the subclasses of `base` in this package, without those of programs."""
    own = [c for c in base.__subclasses__() if f"{c.__module__}.".startswith("pyrep.objects.")]
    return [c for direct in own for c in (direct, *_classes(direct))]


def views_of(elements: Iterable[Element], object_type: ObjectType = ObjectType.ALL) -> list[Object]:
    """Return views of the elements of a type."""
    views = [view_of(element) for element in elements]
    return views if object_type == ObjectType.ALL else [v for v in views if v.get_type() == object_type]


def _touch(table: ObjectTable, first: Element, second: Element) -> bool:
    """Return whether the collision shapes of two objects overlap."""
    for parts, pose in table.scene_object(first).solids():
        for others, there in table.scene_object(second).solids():
            for shape, placement in parts:
                if geometry.overlaps(shape, pose_to_se3(pose) * placement, others, pose_to_se3(there)):
                    return True
    return False


def point_part() -> geometry.Part:
    """Return a sphere with a radius of 1 micrometre at the origin, for distance queries."""
    ball = geometry.volume("sphere", (1e-6,))
    return ball, pose_to_se3((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))


def _body_and_link(table: ObjectTable, element: Element) -> tuple[str, str | None]:
    """Return the name of the body in contacts, and the name of the link; None for all links."""
    if element.kind == "link":
        body, _, link = element.name.partition("/")
        return body, link
    if _OWNERS.get(element.kind, element.kind) == "robot":
        description = table.runtime.description
        links = {"robot_link": element.name, "gripper": description.hand_link}
        return description.name, links.get(element.kind)
    return element.name, None


def _link_handle(table: ObjectTable, body: str, link: str) -> int:
    """Return the handle of a link, of its body if only this has one, or -1."""
    ids = {name: identifier for identifier, name in table.world.masks.items()}
    return ids.get(f"{body}/{link}", ids.get(body, -1))


def euler_to_matrix(angles: Numbers) -> FloatArray:
    """Return the rotation (3, 3) Rx(a) Ry(b) Rz(c) of angles (3,) [rad]."""
    (sa, sb, sc), (ca, cb, cc) = np.sin(angles), np.cos(angles)
    x = np.array([[1.0, 0.0, 0.0], [0.0, ca, -sa], [0.0, sa, ca]])
    y = np.array([[cb, 0.0, sb], [0.0, 1.0, 0.0], [-sb, 0.0, cb]])
    z = np.array([[cc, -sc, 0.0], [sc, cc, 0.0], [0.0, 0.0, 1.0]])
    product: FloatArray = x @ y @ z
    return product


def euler_to_quaternion(angles: Numbers) -> FloatArray:
    """Return the quaternion (4,) of the rotation Rx(a) Ry(b) Rz(c) of angles (3,) [rad]."""
    matrix = np.eye(4)
    matrix[:3, :3] = euler_to_matrix(np.asarray(angles, dtype=float))
    return matrix_to_pose(matrix)[3:]


def matrix_to_euler(rotation: FloatArray) -> FloatArray:
    """Return the angles (3,) [rad] of a rotation (3, 3) = Rx(a) Ry(b) Rz(c); c is 0 at a singularity (b = +-90 degrees)."""
    b = float(np.arcsin(np.clip(rotation[0, 2], -1.0, 1.0)))
    if abs(rotation[0, 2]) > 1.0 - 1e-9:
        return np.array([np.arctan2(rotation[2, 1], rotation[1, 1]), b, 0.0])
    return np.array([np.arctan2(-rotation[1, 2], rotation[2, 2]), b, np.arctan2(-rotation[0, 1], rotation[0, 0])])


def _numbers(values: Numbers, count: int, what: str) -> FloatArray:
    """Return values as an array (count,), or raise InvalidPlace with `what` if they are not finite or too few or many."""
    numbers = np.array(values, dtype=float)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise InvalidPlace(f"A {what} has to be {count} finite numbers, not {numbers.tolist()}.")
    return numbers
