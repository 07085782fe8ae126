"""Robot, room, bodies and frames of one world: load, look up, add and remove them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

import numpy as np
import pinocchio as pin

from rlbench_pin.assets import asset_path
from rlbench_pin.errors import RlbenchPinError, RobotModelError, UnknownName
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.scene.reader import resolve_asset
from rlbench_pin.scene.snapshot import ROOM, BodySnapshot, WorldSnapshot
from rlbench_pin.scene.spec import ROOT, BodySpec, SceneSpec
from rlbench_pin.sim.arm.control import SimRobot
from rlbench_pin.sim.arm.gripper import SimGripper
from rlbench_pin.sim.body import Body, Contact, ContactReader, LoadedModel, ObjectJoint, OnMove, inspect
from rlbench_pin.sim.client import PhysicsClient, bullet
from rlbench_pin.sim.frames import Frame, PlaceTree, Region, Sensor
from rlbench_pin.sim.overrides import DynamicsOverrides, TextureOverrides
from rlbench_pin.sim.render.masks import MaskTable
from rlbench_pin.sim.render.raster.stage import Appearance, Finishes, Visuals
from rlbench_pin.sim.render.renderer import Renderer
from rlbench_pin.sim.resting import Resting
from rlbench_pin.sim.room import RoomBody
from rlbench_pin.spatial import IDENTITY, PoseLike
from rlbench_pin.values import as_record, as_whole


class StateKeeper(Protocol):
    """An object outside of the world whose state is saved and restored with the world, in memory."""

    def state(self) -> object:
        """Return the state; it must not change afterwards."""
        ...

    def set_state(self, state: object) -> None:
        """Restore a state from `state()`; the world is restored before."""
        ...


class Contents:
    """Contents of a physics server for one scene: robot, room and bodies, loaded in this order, and the scene's frames.

    A state of a world describes these contents; `World` simulates them.

    Args:
        client: The physics server.
        spec: The scene.
        robot: The arm behind the table.
        timestep: Physics step [s].
        substeps: Physics steps in a control tick.
    """

    def __init__(self, client: PhysicsClient, spec: SceneSpec, robot: RobotDescription, timestep: float, substeps: int) -> None:
        self.client, self.spec = client, spec
        self.keepers: list[StateKeeper] = []
        self._ticks = 0
        self._masks, self._contacts = MaskTable(), ContactReader(client)
        self.places = PlaceTree(spec, self.body)
        arm = load_robot(client, robot)
        self._register(robot.name, arm)
        self.room = load_room(client, self.places.carry)
        for body in self.room.values():
            self._register(body.name, body.model)
        self._masks.begin_objects()
        self.bodies: dict[str, Body] = {}
        self._spawned: dict[str, BodySpec] = {}
        for body_spec in spec.body:
            self._load(body_spec, arm)
        for joint in spec.joint:
            self.joint(joint.name).configure(joint)
        self.places.place_bodies()
        self.resting = Resting(client, self.bodies, self.room)
        room_ids = {name: self._masks.first_id(body.model) for name, body in self.room.items()}
        appearance = Appearance(self._mixed_colors, self._finishes, lambda: self.robot.hidden_links)
        self.renderer = Renderer(client, self.room, room_ids, self._masks.table, appearance)
        self.robot = SimRobot(arm, robot, self._contacts, timestep, substeps)
        self.texture_overrides = TextureOverrides(self.renderer, arm, self.bodies, self.room)
        self.dynamics_overrides = DynamicsOverrides(self.robot)
        self.gripper = SimGripper(self.robot, self.body, lambda: tuple(self.bodies.values()))

    def _load(self, spec: BodySpec, robot: LoadedModel) -> Body:
        body = load_body(self.client, spec, self.spec.file, self.places.carry)
        if body.joints:
            join_island(robot, body)
        self.bodies[spec.name] = body
        self.places.add_body(spec)
        self._register(body.name, body.model)
        return body

    def _register(self, name: str, model: LoadedModel) -> None:
        self._masks.add(name, model)
        self._contacts.add(name, model)

    def _mixed_colors(self) -> Visuals:
        return {(b.model.uid, link): colors for b in self.bodies.values() for link, colors in b.mixed_colors.items()}

    def _finishes(self) -> Finishes:
        return {(b.model.uid, link): finishes for b in self.bodies.values() for link, finishes in b.finishes.items()}

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

    def frame(self, name: str) -> Frame:
        """Return a frame, region, sensor or waypoint, or the root."""
        return self.places.frame(name)

    def region(self, name: str) -> Region:
        """Return a region of the scene."""
        return self.places.frame_of_kind(name, Region, "region")

    def sensor(self, name: str) -> Sensor:
        """Return a sensor of the scene."""
        return self.places.frame_of_kind(name, Sensor, "sensor")

    @property
    def frames(self) -> Mapping[str, Frame]:
        """All frames, regions, sensors and waypoints, and the root, by name."""
        return self.places.frames

    @property
    def root(self) -> Frame:
        """The root frame of the task."""
        return self.places.frame(ROOT)

    def placement(self, name: str) -> pin.SE3:
        """Return T_world_x of a body, a link, a frame, `root` or `world`."""
        return self.places.placement(name)

    @property
    def masks(self) -> Mapping[int, str]:
        """Mask id -> name: robot and room below 61, task objects from 61 in the order of the scene file."""
        return dict(self._masks.names)

    @property
    def ticks(self) -> int:
        """Control ticks since the world was built."""
        return self._ticks

    def set_ticks(self, ticks: int) -> None:
        """Set the clock."""
        self._ticks = as_whole(ticks, "ticks", least=0)

    # Changing the world ----------------------------------------------------------------------------------------------

    def place_root(self, pose: PoseLike) -> None:
        """Move the root and all its descendants to a pose (7,); joint positions do not change, velocities become zero."""
        self.root.set_pose(pose)

    @property
    def spawned(self) -> Mapping[str, BodySpec]:
        """Bodies added at run time, in order."""
        return dict(self._spawned)

    def add_body(self, name: str, spec: BodySpec) -> Body:
        """Add a body to the running world; restoring an older state removes it.

        Args:
            name: A name that is not in use.
            spec: Asset and pose; its name is replaced by `name`.

        Raises:
            RlbenchPinError: The name is in use.
            InvalidValue: The name is not a text, or `spec` is not a BodySpec.
        """
        as_record(name, str, "the name of a new body")
        as_record(spec, BodySpec, "spec")
        if name in self.bodies or name in self.room or self.places.contains(name):
            raise RlbenchPinError(f"The name '{name}' is in use. Choose another for the new body.")
        spec = spec.model_copy(update={"name": name})
        body = self._load(spec, self.robot.model)
        self._spawned[name] = spec
        self.places.place_body(name)
        return body

    def remove_body(self, name: str) -> None:
        """Remove a body that `add_body` added.

        Raises:
            RlbenchPinError: The body belongs to the scene file.
        """
        body = self.body(name)
        if name not in self._spawned:
            raise RlbenchPinError(f"'{name}' belongs to the scene file. Remove only bodies that `add_body` added.")
        if name in self.gripper.grasped:
            self.gripper.release()
        self.dynamics_overrides.forget(body.model)
        self.texture_overrides.clear_body(name)
        # The last body takes the place of the removed one, as in PyBullet's own list, by whose order states are restored.
        names = list(self._spawned)
        last = names.pop()
        self._spawned = {n: self._spawned[n] for n in (last if n == name else n for n in names)}
        del self.bodies[name]
        self.places.remove_body(name)
        self._masks.remove(body.model)
        self._contacts.remove(body.model.uid)
        self.client.change(bullet.removeBody, body.model.uid)

    # Queries ---------------------------------------------------------------------------------------------------------

    def contacts(self, body: str | None = None, other: str | None = None) -> tuple[Contact, ...]:
        """Return the contact points of the last physics step: all, those of one body, or those between two."""
        first, second = (None if name is None else self._model(name).uid for name in (body, other))
        return self._contacts.read(first, second)

    def max_penetration(self) -> float:
        """Return the largest penetration depth of all contacts [m]; 0 without contact."""
        return self._contacts.deepest()

    def _model(self, name: str) -> LoadedModel:
        is_robot = isinstance(name, str) and name == self.robot.description.name
        return self.robot.model if is_robot else self.body(name).model

    def snapshot(self) -> WorldSnapshot:
        """Return names, shapes, poses and joint values at this instant; bodies without collision shapes are left out."""
        masses = self.dynamics_overrides.changed_masses
        seen = [_captured(body, {}, in_room=True) for body in self.room.values()]
        seen += [_captured(body, masses(body.model)) for body in self.bodies.values()]
        bodies = tuple(body for body in seen if body.link_names)
        return WorldSnapshot(bodies, self.robot.joint_positions, self.robot.fingers, self.gripper.held)


def _captured(body: Body, masses: dict[str, float], in_room: bool = False) -> BodySnapshot:
    model, links = body.model, body.model.collision_links()
    poses = np.array([body.link_pose(link) for link in links]).reshape(-1, 7)
    collides = body.collides and body.obstacle
    return BodySnapshot(body.name, model.urdf, links, poses, model.scale, collides, body.fixed, in_room=in_room, masses=masses)


def load_robot(client: PhysicsClient, description: RobotDescription) -> LoadedModel:
    """Load the arm, fixed at its base pose.

    Raises:
        RobotModelError: Its gripper does not have two fingers.
    """
    if (fingers := len(description.gripper_joints)) != 2:
        raise RobotModelError(
            f"The simulation drives a gripper with two fingers; '{description.name}' has {fingers} gripper joints. "
            "Describe a gripper with two, or use this arm only for planning and control."
        )
    uid = client.load(description.urdf, f"robot '{description.name}'", np.array(description.base_pose), fixed=True)
    return inspect(client, uid, description.urdf, 1.0)


def load_room(client: PhysicsClient, on_move: OnMove) -> dict[str, RoomBody]:
    """Load table, floor, walls and ceiling; their files are in world coordinates."""
    return {name: _room_body(client, name, on_move) for name in ROOM}


def _room_body(client: PhysicsClient, name: str, on_move: OnMove) -> RoomBody:
    urdf = asset_path(f"room/{name}.urdf")
    uid = client.load(urdf, "the room", IDENTITY, fixed=True)
    return RoomBody(name, inspect(client, uid, urdf, 1.0), fixed=True, collides=True, on_move=on_move).hide()


def load_body(client: PhysicsClient, spec: BodySpec, scene_file: str, on_move: OnMove) -> Body:
    """Load one body of a scene at the world origin; its pose is set afterwards."""
    urdf = resolve_asset(Path(scene_file), spec.asset)
    uid = client.load(urdf, f"body '{spec.name}'", IDENTITY, spec.fixed, spec.scale)
    body = Body(spec.name, inspect(client, uid, urdf, spec.scale), fixed=spec.fixed, collides=spec.collides, on_move=on_move)
    if spec.color is not None:
        body.set_color(spec.color)
    return body


def join_island(robot: LoadedModel, body: Body) -> None:
    """Put a body with joints into the same solver island as the arm, by a constraint without force.

    PyBullet sorts the constraints of joints, and the contacts between the same two links of several convex parts, by islands.
    With two or more islands the order within an island is not fixed. Islands depend on contacts and on earlier simulation, so
    that the same motion would differ in the last bits between runs. With one island there is no sorting.
    """
    link = min(joint.index for joint in body.model.joints.values())
    zero = [0.0, 0.0, 0.0]
    change = robot.client.change
    tie = change(bullet.createConstraint, robot.uid, 0, body.model.uid, link, bullet.JOINT_POINT2POINT, zero, zero, zero)
    change(bullet.changeConstraint, tie, maxForce=0.0)
