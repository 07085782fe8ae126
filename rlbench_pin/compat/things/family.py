"""Who hangs on whom."""

from __future__ import annotations

from collections.abc import Iterable

from rlbench_pin.compat.things.element import Element, UnsupportedCall
from rlbench_pin.compat.things.names import camera_of, robot_prefix
from rlbench_pin.compat.things.placed import Placed
from rlbench_pin.compat.things.thing import child_link, joint_of_link
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.scene.spec import ROOT, WORLD
from rlbench_pin.sim import World
from rlbench_pin.urdf import UrdfJoint, read_urdf

_MOVABLE_KINDS = ("body", "frame", "placed")


class Family:
    """Answers who the parent of a thing is.

    Args:
        world: The world.
        robot: Its arm.
        placed: Things beside the physics, by name.
        parents: Parents that programs changed.
    """

    def __init__(
        self, world: World, robot: RobotDescription, placed: dict[str, Placed], parents: dict[Element, Element | None]
    ) -> None:
        self._world, self._robot, self._placed, self._parents = world, robot, placed, parents

    def parent(self, element: Element) -> Element | None:
        """Return what an element hangs on; None for the world."""
        if element in self._parents:
            return self._parents[element]
        owner, _, part = element.name.partition("/")
        match element.kind:
            case "body" | "frame":
                return self.native(self._world.places.parent(element.name) or WORLD)
            case "link":
                joint, below = joint_of_link(self._world.body(owner), part)
                return Element("joint", f"{owner}/{joint}") if joint else self._link(owner, below)
            case "joint":
                joints = {j.name: j for j in read_urdf(self._world.body(owner).model.urdf).joints}
                return self._link(owner, joints[part].parent)
            case "placed":
                return self._placed[element.name].parent
            case "camera":
                name, is_mask = camera_of(element.name)
                if is_mask:
                    return Element("camera", element.name.removesuffix("_mask"))
                return Element("gripper", f"{robot_prefix(self._robot)}_gripper") if name == "wrist" else None
            case "tip" | "gripper" | "robot_joint" | "robot_link":
                return Element("robot", robot_prefix(self._robot))
            case _:
                return None

    def ancestors(self, element: Element) -> list[Element]:
        """Return its parent, the parent of that, and so on."""
        found: list[Element] = []
        while (parent := self.parent(element)) is not None:
            found.append(parent)
            element = parent
        return found

    def tree(self, elements: Iterable[Element], root: Element | None, depth: int = -1) -> list[Element]:
        """Return which of the elements hang on `root` (None: the world), near or far.

        Args:
            elements: All there are.
            root: Left out itself.
            depth: 1 keeps direct children only; -1 keeps all.
        """
        found = []
        for element in elements:
            chain: list[Element | None] = [*self.ancestors(element), None]
            if root in (chain if depth < 0 else chain[:depth]):
                found.append(element)
        return found

    def native(self, name: str) -> Element | None:
        """Return the element that the world calls `name`; None for `world`."""
        owner, _, part = name.partition("/")
        if name == WORLD:
            return None
        if name == ROOT:
            return Element("root", ROOT)
        if part:
            return self._link(owner, part)
        if owner in self._world.frames:
            return Element("frame", owner)
        return Element("room" if owner in self._world.room else "body", owner)

    def _link(self, body: str, link: str) -> Element:
        return Element("body", body) if link == self._world.body(body).links[0] else Element("link", f"{body}/{link}")

    def spec_parent(self, body: str) -> str:
        """Return the parent of a body as its scene file, or the program that made it, says."""
        specs = {spec.name: spec for spec in (*self._world.spec.body, *self._world.spawned.values())}
        return {**specs, **self._world.spawned}[body].parent

    def robot_joint(self, name: str) -> UrdfJoint:
        """Return what the model file says of a joint of the arm or hand, by its known name."""
        fingers, prefix = "_gripper_joint", robot_prefix(self._robot)
        number = int(name.rpartition("joint")[2]) - 1
        names = self._robot.gripper_joints if name.startswith(prefix + fingers) else self._robot.arm_joints
        return next(j for j in read_urdf(self._robot.urdf).joints if j.name == names[number])

    def native_name(self, element: Element | None) -> str:
        """Return what the world calls a parent, or the nearest of its ancestors that the world knows."""
        while element is not None and element.kind not in ("root", "body", "link", "joint", "frame", "room"):
            element = self.parent(element)
        if element is not None and element.kind == "joint":
            owner, _, joint = element.name.partition("/")
            return f"{owner}/{child_link(self._world.body(owner), joint)}"
        return WORLD if element is None else element.name

    def check(self, element: Element, parent: Element | None) -> None:
        """Raise when a thing cannot hang on another."""
        call = f"set_parent of '{element.name}'"
        if element.kind not in _MOVABLE_KINDS:
            raise UnsupportedCall(call, "it is a fixed part of the scene.", "Hang other things on it, or make a Dummy.")
        if parent is None:
            return
        chain = [parent, *self.ancestors(parent)]
        if element in chain:
            raise RlbenchPinError(f"'{parent.name}' cannot be the parent of '{element.name}', because it hangs on it.")
        if element.kind != "placed" and any(e.kind.startswith(("robot", "tip", "gripper", "camera")) for e in chain):
            raise UnsupportedCall(
                call,
                f"'{parent.name}' is moved by the arm.",
                "Hold a Shape with `gripper.grasp`; make a Dummy to follow the arm.",
            )
