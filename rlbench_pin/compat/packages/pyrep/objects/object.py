"""What all things of a scene can do."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

import numpy as np

from pyrep.backend.poses import PoseMethods
from pyrep.backend.switches import Switches
from pyrep.const import ObjectType
from pyrep.errors import ObjectAlreadyRemovedError, PyRepError, UnsupportedCall, WrongObjectTypeError
from rlbench_pin.compat.devices import configuration
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.compat.things import Element, ObjectTable, Thing, UnknownObject, shape_making, solids
from rlbench_pin.compat.things import ObjectType as TypeName
from rlbench_pin.errors import RlbenchPinError


class Object(PoseMethods, Switches):
    """A view of one thing of the scene; it holds a name only, and looks the thing up at each call.

    Args:
        name_or_handle: Name or handle of the thing.

    Raises:
        UnknownObject: There is no such thing; also a `RuntimeError`.
        WrongObjectTypeError: It is of another type.
    """

    kinds: ClassVar[tuple[TypeName, ...]] = ()
    """Types that the class stands for; none stands for any."""

    def __init__(self, name_or_handle: str | int | Element) -> None:
        self._removed = False
        if isinstance(name_or_handle, Element):
            self._element = name_or_handle
        elif isinstance(name_or_handle, str):
            self._element = self.table.find(name_or_handle, self.kinds)
        else:
            self._element = self.table.of_handle(int(name_or_handle))
        found = self.table.thing(self._element).type
        if self.kinds and found not in self.kinds:
            raise WrongObjectTypeError(
                f"'{name_or_handle}' is a {found}, not a {type(self).__name__}. `Object.get_object` makes the class that fits."
            )

    # Who it is -------------------------------------------------------------------------------------------------------

    @property
    def table(self) -> ObjectTable:
        """All things of the present world."""
        return Simulator.current().objects

    @property
    def element(self) -> Element:
        """What it stands for in the world.

        Raises:
            ObjectAlreadyRemovedError: After `remove()`.
        """
        if self._removed:
            raise ObjectAlreadyRemovedError(f"'{self._element.name}' was removed. Make or look up another object.")
        return self._element

    @property
    def thing(self) -> Thing:
        """What answers for it in the world now."""
        return self.table.thing(self.element)

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
        """What is compared; valid after `remove()` as well."""
        return self._element

    @staticmethod
    def exists(name: str) -> bool:
        """Whether something in the scene has that name."""
        try:
            Simulator.current().objects.find(name)
        except UnknownObject:
            return False
        return True

    @staticmethod
    def get_object_type(name: str) -> ObjectType:
        """Return the type of what has that name."""
        table = Simulator.current().objects
        return ObjectType[table.thing(table.find(name)).type.upper()]

    @staticmethod
    def get_object_name(name_or_handle: str | int) -> str:
        """Return the name of what has that name or handle."""
        table = Simulator.current().objects
        return table.name(table.find(name_or_handle) if isinstance(name_or_handle, str) else table.of_handle(name_or_handle))

    def get_type(self) -> ObjectType:
        """Return the type of this thing."""
        return ObjectType[self.thing.type.upper()]

    def get_handle(self) -> int:
        """Return its number; for what masks show, the number in the masks."""
        return self.table.handle(self.element)

    def still_exists(self) -> bool:
        """Whether it is still part of the scene."""
        return not self._removed and self.table.exists(self._element)

    def get_name(self) -> str:
        """Return its name."""
        return self.table.name(self.element)

    def set_name(self, name: str) -> None:
        """Give it another name; the old one no longer stands in lists."""
        self.table.rename(self.element, name)

    # Who it belongs to -----------------------------------------------------------------------------------------------

    @staticmethod
    def get_object(name_or_handle: str | int) -> Object:
        """Return the thing of that name or handle, as an object of the class for its type."""
        table = Simulator.current().objects
        element = table.find(name_or_handle) if isinstance(name_or_handle, str) else table.of_handle(int(name_or_handle))
        return view_of(element)

    def get_parent(self) -> Object | None:
        """Return what it hangs on, None for the world."""
        parent = self.table.parent(self.element)
        return None if parent is None else view_of(parent)

    def set_parent(self, parent_object: Object | None, keep_in_place: bool = True) -> None:
        """Let it move with another thing.

        Args:
            parent_object: With what; None is the world.
            keep_in_place: Stay where it is; otherwise keep the pose relative to the parent.
        """
        parent = None if parent_object is None else parent_object.element
        self.table.set_parent(self.element, parent, keep_in_place)

    def get_objects_in_tree(
        self, object_type: ObjectType = ObjectType.ALL, exclude_base: bool = True, first_generation_only: bool = False
    ) -> list[Object]:
        """Return what hangs on it.

        Args:
            object_type: Only things of this type.
            exclude_base: Leave itself out.
            first_generation_only: Direct children only.
        """
        table = self.table
        tree = table.family.tree(table.elements(), self.element, 1 if first_generation_only else -1)
        return views_of(tree if exclude_base else [self.element, *tree], object_type)

    # Boxes, contact, distance ----------------------------------------------------------------------------------------

    def get_bounding_box(self) -> list[float]:
        """Return min x, max x, min y, max y, min z, max z of its box in its own frame [m]; without what hangs on it."""
        return [float(v) for v in self.thing.box().T.ravel()]

    def get_model_bounding_box(self) -> list[float]:
        """Return the same six numbers for everything that hangs on it as well."""
        return [float(v) for v in solids.tree_box(self.table, self.element).T.ravel()]

    def check_collision(self, obj: Object | None = None) -> bool:
        """Say whether it touches a thing, or anything collidable outside its own tree when `obj` is None."""
        return solids.collides(self.table, self.element, None if obj is None else obj.element)

    def check_distance(self, other: Object) -> float:
        """Return the smallest distance to another thing [m]; 0 where they touch."""
        return solids.distance(self.table, self.element, other.element)

    def get_contact(self, contact_obj: Object | None = None, get_contact_normal: bool = True) -> list[dict[str, Any]]:
        """Return the contact points of the last physics step.

        Args:
            contact_obj: With what; None is everything.
            get_contact_normal: Kept for programs that pass it; normals are always returned.

        Returns:
            For each point a dict with `contact_handles` (2 numbers) and `contact` (6,): position [m], normal force vector [N].
        """
        other = None if contact_obj is None else contact_obj.element
        return solids.contacts(self.table, self.element, other)

    def get_velocity(self) -> tuple[np.ndarray, np.ndarray]:
        """Return linear (3,) [m/s] and angular (3,) [rad/s] velocity in world axes."""
        velocity = self.thing.velocity
        return velocity[:3], velocity[3:]

    def get_configuration_tree(self) -> configuration.ConfigurationTree:
        """Return where it and all that hangs on it are, for `PyRep.set_configuration_tree`."""
        return configuration.read(self.table, self.element)

    # Models ----------------------------------------------------------------------------------------------------------

    def is_model(self) -> bool:
        """Whether it is a model: what `set_model` said, otherwise whether anything hangs on it."""
        return self.flag("model", default=bool(self.table.children(self.element)))

    def set_model(self, value: bool) -> None:
        """Say whether `is_model` calls it a model; nothing else depends on that."""
        self.set_flag("model", value)

    def set_model_renderable(self, value: bool) -> None:
        """Show it and all that hangs on it to cameras, or hide it."""
        for member in self.get_objects_in_tree(exclude_base=False):
            member.set_renderable(value)

    def is_model_respondable(self) -> bool:
        """Whether all shapes of its tree touch other things."""
        return all(shape.is_respondable() for shape in self.get_objects_in_tree(ObjectType.SHAPE, exclude_base=False))

    def set_model_respondable(self, value: bool) -> None:
        """Let all shapes of its tree touch other things, or pass through them."""
        for shape in self.get_objects_in_tree(ObjectType.SHAPE, exclude_base=False):
            shape.set_respondable(value)

    def is_model_dynamic(self) -> bool:
        """Whether all shapes of its tree are moved by physics."""
        return all(shape.is_dynamic() for shape in self.get_objects_in_tree(ObjectType.SHAPE, exclude_base=False))

    def get_explicit_handling(self) -> int:
        """Return 1 for sensors that are read only when asked, which is how all sensors work here."""
        return 1

    def set_explicit_handling(self, value: int) -> None:
        """Accepted; sensors are read when asked, whatever is set."""

    def get_extension_string(self) -> str:
        """Return the words that a waypoint of a scene file carries; empty for other things."""
        return solids.extension_string(self.table, self.element)

    def scale_object(self, scale_x: float, scale_y: float, scale_z: float) -> None:
        """Refused: sizes are part of the model."""
        raise UnsupportedCall(
            "scale_object", "sizes are part of the model file.", "Use `scale` in the scene file, or `Shape.create`."
        )

    def save_model(self, path: str) -> None:
        """Refused: there are no ttm files here."""
        raise UnsupportedCall("save_model", "there are no ttm files here.", "Scenes are TOML files and models URDF files.")

    def copy(self) -> Object:
        """Make another one like it; only what a program made, and shapes, can be copied."""
        raise UnsupportedCall(f"copy of '{self.get_name()}'", "it is part of the fixed scene.", "Copy a Shape or a Dummy.")

    def remove(self) -> None:
        """Take it out of the scene; what hangs on it stays where it is.

        Raises:
            PyRepError: It belongs to the scene file: only what a program made can be removed.
        """
        try:
            shape_making.discard(self.table, self.element)
        except RlbenchPinError as error:
            raise PyRepError(str(error)) from error
        self._removed = True


def view_of(element: Element) -> Object:
    """Return an object of the class for the type of an element."""
    found = Simulator.current().objects.thing(element).type
    classes = [c for c in _classes(Object) if c.kinds[:1] == (found,)]
    return (classes or [Object])[0](element)


def _classes(base: type[Object]) -> list[type[Object]]:
    """Return the classes of this package that derive from `base`; those that programs derive are theirs alone."""
    own = [c for c in base.__subclasses__() if c.__module__.startswith("pyrep.objects.")]
    return [c for direct in own for c in (direct, *_classes(direct))]


def views_of(elements: Iterable[Element], object_type: ObjectType = ObjectType.ALL) -> list[Object]:
    """Return objects for those elements that are of a type."""
    views = [view_of(element) for element in elements]
    return views if object_type == ObjectType.ALL else [v for v in views if v.get_type() == object_type]
