"""The table of all objects of the current world: names, handles, parents, and objects that programs added."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from rlbench_pin.compat.objects.elements import (
    CAMERA_NAMES,
    MASK_SUFFIX,
    ROOM_NAMES,
    Element,
    ObjectType,
    UnknownObject,
    UnsupportedCall,
    camera_of,
    robot_elements,
    robot_names,
    usual_name,
)
from rlbench_pin.compat.objects.scene_objects import (
    BodyObject,
    CameraObject,
    Cameras,
    FrameObject,
    JointObject,
    LinkObject,
    Placed,
    PlacedObject,
    RobotObject,
    SceneObject,
    WholeRobotObject,
    child_link,
    fixed_objects,
    hangs_in_task,
    joint_of_link,
)
from rlbench_pin.environment import ObservationConfig
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene.spec import ROOT, WORLD
from rlbench_pin.spatial import FloatArray, compose, relative
from rlbench_pin.urdf import UrdfJoint, read_urdf

FIRST_HANDLE = 100_000
"""First handle of objects that are not in masks."""


@dataclass(frozen=True, eq=False)
class _Kept:
    """State of the table that is restored with the world."""

    placed: dict[str, Placed]
    """Placed objects by name."""
    parents: dict[Element, Element | None]
    """Parents that programs changed."""


class ObjectTable:
    """All named objects of one world.

    Args:
        runtime: The world and its task.
        config: Contents of observations; its cameras are the five fixed ones.
        before: The table of the previous world, whose objects that belong to no task are copied.

    Attributes:
        runtime: The world and its task.
        placed: Objects that are not part of the physics (dummies, cameras, paths, planes), by name.
        parents: Parents that programs changed.
        cameras: The five cameras.
        permanent: Bodies that a program added without a loaded task; they exist in the worlds of all later tasks.
        flags: Properties such as `detectable` that differ from their default.
    """

    def __init__(self, runtime: Runtime, config: ObservationConfig, before: ObjectTable | None = None) -> None:
        self.runtime, self.world = runtime, runtime.world
        self.placed: dict[str, Placed] = fixed_objects(runtime.description)
        self.parents: dict[Element, Element | None] = {}
        self.flags: dict[tuple[Element, str], object] = {}
        self.cameras = Cameras(runtime, config)
        self.permanent: set[str] = set()
        self._names: dict[Element, str] = {}
        self._handles: dict[Element, int] = {}
        if before is not None:
            self._take_over(before)
        self.world.keepers.append(self)

    def _take_over(self, before: ObjectTable) -> None:
        """Copy the objects that belong to no task from the table of the previous world, which is still open."""
        self.placed |= {name: p for name, p in before.placed.items() if not hangs_in_task(before.placed, name)}
        self.permanent = {name for name in before.permanent if name in before.world.spawned}
        for name in sorted(self.permanent):
            there, here = before.world.body(name), self.world.add_body(name, before.world.spawned[name])
            here.set_pose(there.pose)
            here.set_colors(there.colors)
            here.set_collides(there.collides)
            self.world.dynamics_overrides.set_fixed(here, there.fixed)
            self.rename(Element("body", name), before.name(Element("body", name)))

    # Names and handles -----------------------------------------------------------------------------------------------

    def elements(self) -> Iterator[Element]:
        """Yield all objects, those of the task first."""
        world = self.world
        yield Element("root", ROOT)
        for name, body in world.bodies.items():
            yield Element("body", name)
            yield from (Element("link", f"{name}/{link}") for link in body.links[1:])
            yield from (Element("joint", f"{name}/{joint}") for joint in body.joints)
        yield from (Element("frame", name) for name in world.frames if name != ROOT)
        yield from (Element("room", name) for name in world.room)
        yield from robot_elements(self.runtime.description, tuple(world.robot.model.links))
        yield from (Element("camera", name + suffix) for name in CAMERA_NAMES for suffix in ("", MASK_SUFFIX))
        yield from (Element("placed", name) for name in self.placed)

    def find(self, name: str, types: tuple[ObjectType, ...] = ()) -> Element:
        """Return the object with a name; of several, the first that has one of `types`.

        Raises:
            UnknownObject: There is no such object.
        """
        found = [e for e in self.elements() if self.name(e) == name]
        found = found or [e for e in self.elements() if name in self._other_names(e)]
        if not found:
            raise UnknownObject("object of this scene", name, tuple(self.name(e) for e in self.elements()))
        if len({e.name.partition("/")[0] for e in found}) > 1 and found[0].kind in ("link", "joint"):
            found = [found[0]] if self.name(found[0]) == name else found
        wanted = [e for e in found if self.scene_object(e).type in types]
        return (wanted or found)[0]

    def _other_names(self, element: Element) -> tuple[str, ...]:
        """Return the names under which `find` also finds an object, if no object has this name in programs."""
        if element.kind == "root":
            return (ROOT,)
        if element.kind in ("link", "joint"):
            return (element.name, element.name.partition("/")[2])
        if element.kind == "body":
            return (f"{element.name}/{self.world.body(element.name).links[0]}", element.name)
        if element.kind == "frame":
            return (element.name, *usual_name(element.name, self.world.frames))
        return (element.name,)

    def name(self, element: Element) -> str:
        """Return the name of an object in programs."""
        if element in self._names:
            return self._names[element]
        if element.kind == "root":
            return self.runtime.task.get_name()
        return ROOM_NAMES.get(element.name, element.name) if element.kind == "room" else element.name

    def rename(self, element: Element, name: str) -> None:
        """Change the name of an object in programs."""
        self._names[element] = name

    def forget(self, element: Element) -> None:
        """Remove the name and the flags of a previous object with the same identity."""
        self._names.pop(element, None)
        for key in [k for k in self.flags if k[0] == element]:
            del self.flags[key]

    def free_name(self, stem: str) -> str:
        """Return `stem`; if it is in use, with the first number that makes it unique."""
        taken = {name for e in self.elements() for name in (self.name(e), e.name)}
        return next(n for n in (stem, *(f"{stem}{k}" for k in range(len(taken) + 1))) if n not in taken)

    def exists(self, element: Element) -> bool:
        """Return whether an object is part of the world."""
        if element.kind == "body":
            return element.name in self.world.bodies
        if element.kind in ("link", "joint"):
            owner, _, part = element.name.partition("/")
            body = self.world.bodies.get(owner)
            return body is not None and part in (body.links if element.kind == "link" else body.joints)
        if element.kind == "frame":
            return element.name in self.world.frames
        return element.kind != "placed" or element.name in self.placed

    def handle(self, element: Element) -> int:
        """Return the handle of an object; for objects in masks it is their number in masks."""
        label = self._mask_label(element)
        if label is not None:
            return next(identifier for identifier, name in self.world.masks.items() if name == label)
        return self._handles.setdefault(element, FIRST_HANDLE + len(self._handles))

    def _mask_label(self, element: Element) -> str | None:
        """Return the name of an object in the mask table of the world; None if masks do not show it."""
        if element.kind in ("room", "link"):
            return element.name
        if element.kind == "body":
            links = self.world.body(element.name).links
            return element.name if len(links) == 1 else f"{element.name}/{links[0]}"
        return f"{self.runtime.description.name}/{element.name}" if element.kind == "robot_link" else None

    def of_handle(self, handle: int) -> Element:
        """Return the object with a handle.

        Raises:
            UnknownObject: There is no such object.
        """
        for element in self.elements():
            if (element in self._handles or self._mask_label(element) is not None) and self.handle(element) == handle:
                return element
        raise UnknownObject("object of this scene with the handle", str(handle), tuple(self.world.masks.values()))

    # Objects ----------------------------------------------------------------------------------------------------------

    def scene_object(self, element: Element) -> SceneObject:
        """Return the access to an object.

        Raises:
            UnknownObject: The object no longer exists.
        """
        if not self.exists(element):
            raise UnknownObject("object of this scene", self.name(element), tuple(self.name(e) for e in self.elements()))
        world, (owner, _, part) = self.world, element.name.partition("/")
        match element.kind:
            case "body" | "room":
                return BodyObject(world.body(element.name))
            case "link":
                return LinkObject(world.body(owner), part)
            case "joint":
                return JointObject(world.body(owner), world.joint(element.name))
            case "root" | "frame":
                return FrameObject(world.frame(element.name), world.spec)
            case "camera":
                return CameraObject(self.cameras, element.name)
            case "placed":
                return PlacedObject(self, element.name)
            case _:
                return self._robot_object(element)

    def _robot_object(self, element: Element) -> SceneObject:
        """Return the access to the arm, its tip, its gripper, or one of its joints or links."""
        robot, description = self.world.robot, self.runtime.description
        match element.kind:
            case "robot":
                return WholeRobotObject(robot, element.name)
            case "tip":
                return RobotObject(robot, "dummy", None, element.name)
            case "gripper":
                return RobotObject(robot, "shape", description.hand_link, element.name)
            case "robot_joint":
                return RobotObject(robot, "joint", self.robot_joint(element.name).child, element.name)
            case _:
                return RobotObject(robot, "shape", element.name, element.name)

    # Parents ---------------------------------------------------------------------------------------------------------

    def parent(self, element: Element) -> Element | None:
        """Return the parent of an element; None for the world."""
        if element in self.parents:
            return self.parents[element]
        owner, _, part = element.name.partition("/")
        match element.kind:
            case "body" | "frame":
                return self._native(self.world.places.parent(element.name) or WORLD)
            case "link":
                joint, below = joint_of_link(self.world.body(owner), part)
                return Element("joint", f"{owner}/{joint}") if joint else self._link(owner, below)
            case "joint":
                joints = {j.name: j for j in read_urdf(self.world.body(owner).model.urdf).joints}
                return self._link(owner, joints[part].parent)
            case "placed":
                return self.placed[element.name].parent
            case "camera":
                name, is_mask = camera_of(element.name)
                if is_mask:
                    return Element("camera", element.name.removesuffix("_mask"))
                return Element("gripper", robot_names(self.runtime.description).gripper) if name == "wrist" else None
            case "tip" | "gripper" | "robot_joint" | "robot_link":
                return Element("robot", robot_names(self.runtime.description).arm)
            case _:
                return None

    def ancestors(self, element: Element) -> list[Element]:
        """Return the parent of an element, its grandparent, and so on, up to a child of the world."""
        found: list[Element] = []
        while (parent := self.parent(element)) is not None:
            found.append(parent)
            element = parent
        return found

    def tree(self, root: Element | None, depth: int = -1) -> list[Element]:
        """Return the descendants of `root` (None: the world); with `depth` 1 its direct children only."""
        found = []
        for element in self.elements():
            chain: list[Element | None] = [*self.ancestors(element), None]
            if root in (chain if depth < 0 else chain[:depth]):
                found.append(element)
        return found

    def _native(self, name: str) -> Element | None:
        """Return the element that the world calls `name`; None for `world`."""
        owner, _, part = name.partition("/")
        if name == WORLD:
            return None
        if name == ROOT:
            return Element("root", ROOT)
        if part:
            return self._link(owner, part)
        if owner in self.world.frames:
            return Element("frame", owner)
        return Element("room" if owner in self.world.room else "body", owner)

    def _link(self, body: str, link: str) -> Element:
        """Return the element of a link; the base link of a body is the body itself."""
        return Element("body", body) if link == self.world.body(body).links[0] else Element("link", f"{body}/{link}")

    def _spec_parent(self, body: str) -> str:
        """Return the original parent of a body, from its scene file or from its creation by a program."""
        specs = {spec.name: spec for spec in (*self.world.spec.body, *self.world.spawned.values())}
        return {**specs, **self.world.spawned}[body].parent

    def robot_joint(self, name: str) -> UrdfJoint:
        """Return a joint of the model file of the arm or gripper, by its name in RLBench."""
        robot = self.runtime.description
        is_finger, index = robot_names(robot).place(name)
        joint = (robot.gripper_joints if is_finger else robot.arm_joints)[index]
        return next(j for j in read_urdf(robot.urdf).joints if j.name == joint)

    def _native_name(self, element: Element | None) -> str:
        """Return the name in the world of a parent, or of its nearest ancestor in the world."""
        while element is not None and element.kind not in ("root", "body", "link", "joint", "frame", "room"):
            element = self.parent(element)
        if element is not None and element.kind == "joint":
            owner, _, joint = element.name.partition("/")
            return f"{owner}/{child_link(self.world.body(owner), joint)}"
        return WORLD if element is None else element.name

    def _check_parent(self, element: Element, parent: Element | None) -> None:
        """Raise an error if an object cannot be the parent of another."""
        call = f"set_parent of '{element.name}'"
        if element.kind not in ("body", "frame", "placed"):
            raise UnsupportedCall(call, "it is a fixed part of the scene.", "Attach other objects to it, or create a Dummy.")
        if parent is None:
            return
        chain = [parent, *self.ancestors(parent)]
        if element in chain:
            raise RlbenchPinError(f"'{parent.name}' cannot be the parent of '{element.name}', because it is its descendant.")
        if element.kind != "placed" and any(e.kind.startswith(("robot", "tip", "gripper", "camera")) for e in chain):
            raise UnsupportedCall(
                call,
                f"'{parent.name}' is moved by the arm.",
                "Grasp a Shape with `gripper.grasp`; make a Dummy to follow the arm.",
            )

    def children(self, element: Element | None) -> list[Element]:
        """Return the direct children of an object; None is the world."""
        return [e for e in self.elements() if self.parent(e) == element]

    def set_parent(self, element: Element, parent: Element | None, keep_in_place: bool = True) -> None:
        """Attach an object to a new parent, with which it then moves.

        Args:
            element: The object to attach.
            parent: The new parent; None is the world.
            keep_in_place: Keep the pose in the world; otherwise keep the pose relative to the parent.
        """
        self._check_parent(element, parent)
        item, before = self.scene_object(element), self.parent(element)
        pose = item.pose
        local = pose if before is None else relative(pose, self.scene_object(before).pose)
        if element.kind == "placed":
            self.placed[element.name] = replace(self.placed[element.name], parent=parent)
        else:
            self._set_native_parent(element, self._native_name(parent))
            self.parents[element] = parent
        there = pose if keep_in_place else (local if parent is None else compose(self.scene_object(parent).pose, local))
        self.scene_object(element).set_pose(there, True)

    def _set_native_parent(self, element: Element, native: str) -> None:
        """Set the parent of a body or frame by its name in the world."""
        if element.kind == "body":
            self.world.places.set_parent(element.name, native)
        else:
            self.world.frame(element.name).set_parent(native, keep_in_place=True)

    def carry(self, element: Element, old: FloatArray, new: FloatArray) -> None:
        """Move the objects that programs attached to an object that moved from pose `old` to `new`."""
        for child, parent in self.parents.items():
            if parent == element and parent.kind == "placed" and self.exists(child):
                item = self.scene_object(child)
                item.set_pose(compose(new, relative(item.pose, old)), True)
        for name, placed in list(self.placed.items()):
            if placed.parent == element:
                below = placed.local
                self.carry(Element("placed", name), compose(old, below), compose(new, below))

    # Saved and restored with the world -------------------------------------------------------------------------------

    def state(self) -> object:
        """Return the placed objects and the changed parents."""
        return _Kept(dict(self.placed), dict(self.parents))

    def set_state(self, state: object) -> None:
        """Restore a result of `state()`; placed objects that belong to no task do not change."""
        assert isinstance(state, _Kept)
        hanging = {name for name in self.placed if hangs_in_task(self.placed, name)}
        for name in hanging:
            del self.placed[name]
        back = hanging | {name for name in state.placed if hangs_in_task(state.placed, name)}
        self.placed.update({name: state.placed[name] for name in back & set(state.placed)})
        self._restore_parents(state.parents)

    def _restore_parents(self, parents: dict[Element, Element | None]) -> None:
        """Restore changed parents, and reset all other changed parents to the original ones."""
        for element in [e for e in self.parents if e not in parents]:
            del self.parents[element]
            if element.kind == "body" and self.exists(element):
                self.world.places.set_parent(element.name, self._spec_parent(element.name))
        for element, parent in parents.items():
            self.parents[element] = parent
            if element.kind == "body":
                self.world.places.set_parent(element.name, self._native_name(parent))
