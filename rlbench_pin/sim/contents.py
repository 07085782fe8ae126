"""The bodies of one world, with their mask ids, contacts and places."""

from __future__ import annotations

from collections.abc import Mapping

from rlbench_pin.errors import RlbenchPinError, UnknownName
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import build
from rlbench_pin.sim.bodies.body import Body
from rlbench_pin.sim.bodies.joint import ObjectJoint
from rlbench_pin.sim.bodies.model import LoadedModel
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.contacts import ContactReader
from rlbench_pin.sim.places import PlaceTree
from rlbench_pin.sim.render.masks import MaskTable
from rlbench_pin.sim.render.raster.stage import Looks, Visuals
from rlbench_pin.values import as_record


class Contents:
    """Robot, room and bodies, loaded in this order.

    Args:
        client: The physics server.
        spec: What the scene file says.
        robot: The arm behind the table.

    Attributes:
        robot: The loaded arm.
        room: Table, floor and walls, by name.
        room_ids: Mask id of each of them.
        bodies: Bodies of the scene and those added at run time, by name.
        places: Frames, and the parents of frames and bodies.
        masks: Mask ids of all links.
        contacts: Reads contact points.
    """

    def __init__(self, client: PhysicsClient, spec: SceneSpec, robot: RobotDescription) -> None:
        self._client, self._spec, self._robot_name = client, spec, robot.name
        self.masks, self.contacts = MaskTable(), ContactReader(client)
        self.places = PlaceTree(spec, self.body)
        self.robot = build.load_robot(client, robot)
        self.masks.add(robot.name, self.robot)
        self.contacts.add(robot.name, self.robot)
        self.room = build.load_room(client, self.places.carry)
        for body in self.room.values():
            self._register(body)
        self.masks.begin_objects()
        self.room_ids = {name: self.masks.first_id(body.model) for name, body in self.room.items()}
        self.bodies: dict[str, Body] = {}
        self._spawned: dict[str, BodySpec] = {}
        self._load_scene()

    def _load_scene(self) -> None:
        for body in self._spec.body:
            self._load(body)
        for joint in self._spec.joint:
            self.joint(joint.name).configure(joint)
        self.places.place_bodies()

    def _load(self, spec: BodySpec) -> Body:
        body = build.load_body(self._client, spec, self._spec.file, self.places.carry)
        if body.joints:
            build.share_island(self.robot, body)
        self.bodies[spec.name] = body
        self.places.add_body(spec)
        self._register(body)
        return body

    def _register(self, body: Body) -> None:
        self.masks.add(body.name, body.model)
        self.contacts.add(body.name, body.model)

    @property
    def looks(self) -> Looks:
        """What PyBullet does not tell of the visuals of bodies."""
        return Looks(self._mixed_colors, self._gloss)

    def _mixed_colors(self) -> Visuals:
        return {(b.model.uid, link): colors for b in self.bodies.values() for link, colors in b.mixed_colors.items()}

    def _gloss(self) -> Visuals:
        return {(b.model.uid, link): gloss for b in self.bodies.values() for link, gloss in b.gloss.items()}

    # Lookup ----------------------------------------------------------------------------------------------------------

    def body(self, name: str) -> Body:
        """Return a body of the scene or the room.

        Raises:
            UnknownName: There is none of that name.
        """
        body = (self.bodies.get(name) or self.room.get(name)) if isinstance(name, str) else None
        if body is None:
            raise UnknownName("body of this scene", name, (*self.bodies, *self.room))
        return body

    def joint(self, name: str) -> ObjectJoint:
        """Return the joint called `<body>/<joint>`.

        Raises:
            UnknownName: There is none of that name.
        """
        body, _, joint = name.partition("/") if isinstance(name, str) else ("", "", "")
        if body not in self.bodies or joint not in self.bodies[body].joints:
            known = [f"{b.name}/{j}" for b in self.bodies.values() for j in b.joints]
            raise UnknownName("joint of this scene", name, known)
        return self.bodies[body].joints[joint]

    def model(self, name: str) -> LoadedModel:
        """Return what was loaded for the robot or a body.

        Raises:
            UnknownName: There is none of that name.
        """
        return self.robot if isinstance(name, str) and name == self._robot_name else self.body(name).model

    def joints_with_springs(self) -> list[ObjectJoint]:
        """Joints that a spring pulls, in the order of the scene file."""
        return [joint for body in self.bodies.values() for joint in body.joints.values() if joint.has_spring]

    # Bodies added at run time ----------------------------------------------------------------------------------------

    @property
    def spawned(self) -> Mapping[str, BodySpec]:
        """Bodies added at run time, in order."""
        return dict(self._spawned)

    def add(self, name: str, spec: BodySpec) -> Body:
        """Add a body.

        Args:
            name: Name that is not in use.
            spec: What to load and where; its own name is replaced by `name`.

        Raises:
            RlbenchPinError: The name is in use.
            InvalidValue: The name is no text, or the spec none.
        """
        as_record(name, str, "the name of a new body")
        as_record(spec, BodySpec, "spec")
        if name in self.bodies or name in self.room or self.places.contains(name):
            raise RlbenchPinError(f"The name '{name}' is in use. Choose another for the new body.")
        spec = spec.model_copy(update={"name": name})
        body = self._load(spec)
        self._spawned[name] = spec
        self.places.place_body(name)
        return body

    def remove(self, name: str) -> None:
        """Remove a body that `add` made and that nothing holds.

        Raises:
            RlbenchPinError: The body belongs to the scene file.
        """
        body = self.body(name)
        if name not in self._spawned:
            raise RlbenchPinError(f"'{name}' belongs to the scene file; only bodies made by add_body can be removed.")
        self._close_gap(name)
        del self.bodies[name]
        self.places.remove_body(name)
        self.masks.remove(body.model)
        self.contacts.remove(body.model.uid)
        self._client.change(bullet.removeBody, body.model.uid)

    def _close_gap(self, name: str) -> None:
        """Forget a run-time body; the last one takes its place, as in PyBullet's own list, by whose order states are restored."""
        names = list(self._spawned)
        last = names.pop()
        order = [last if n == name else n for n in names]
        self._spawned = {n: self._spawned[n] for n in order}
