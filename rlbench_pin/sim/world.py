"""A running physics world: one scene, one robot, one PyBullet server."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from types import TracebackType

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import RlbenchPinError, UnknownName
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.scene.spec import ROOT, BodySpec, SceneSpec
from rlbench_pin.sim import build, portable, state
from rlbench_pin.sim.arm.gripper import SimGripper
from rlbench_pin.sim.arm.robot import SimRobot
from rlbench_pin.sim.bodies.body import Body
from rlbench_pin.sim.bodies.joint import ObjectJoint
from rlbench_pin.sim.capture import capture
from rlbench_pin.sim.client import bullet, open_client
from rlbench_pin.sim.contacts import Contact, ContactReader
from rlbench_pin.sim.frame import Frame, Region
from rlbench_pin.sim.places import PlaceTree
from rlbench_pin.sim.render.camera import CameraView, Pictures
from rlbench_pin.sim.render.egl import RendererName
from rlbench_pin.sim.render.masks import MaskTable
from rlbench_pin.sim.render.renderer import Renderer
from rlbench_pin.sim.render.shadows import ShadowMap
from rlbench_pin.sim.render.wardrobe import Wardrobe
from rlbench_pin.sim.sensor import Sensor
from rlbench_pin.sim.state import WorldState
from rlbench_pin.sim.tuning import Tuning
from rlbench_pin.spatial import PoseLike


class World:
    """Everything that is simulated; a context manager that frees the physics server.

    Args:
        spec: What the scene file says.
        robot: Which arm stands behind the table.
        timestep: Physics step [s].
        control_dt: Control tick [s], a whole number of physics steps.
        renderer: Who draws moving things: `cpu`, `egl`, or `auto` for EGL where there is one.

    Attributes:
        spec: The scene it was built from.
        robot: Arm and fingers.
        gripper: The hand and what it holds.
        bodies: Bodies of the scene and those added at run time, by name.
        room: Table, floor and walls, by name.
        renderer: Takes the pictures; its `lighting` may be replaced.
        wardrobe: Puts textures on things and takes them off.
        tuning: Scales masses, friction, damping and gains, and takes it back.
        on_step: Called after every tick.
        on_physics: Called before every physics step; may command the arm.
        client: The physics server, for modules of this folder only.
        saved_states: States that someone still holds.
    """

    def __init__(
        self,
        spec: SceneSpec,
        robot: RobotDescription,
        *,
        timestep: float = 1.0 / 240.0,
        control_dt: float = 0.05,
        renderer: RendererName = "cpu",
    ) -> None:
        self.spec, self.timestep, self.control_dt = spec, timestep, control_dt
        self._substeps = _whole_ratio(control_dt, timestep)
        self._ticks = 0
        self.on_step: list[Callable[[], None]] = []
        self.on_physics: list[Callable[[], None]] = []
        self.client = open_client(timestep, renderer)
        self._finalizer = weakref.finalize(self, self.client.close)
        self.saved_states: weakref.WeakSet[WorldState] = weakref.WeakSet()
        self._origin: WorldState | None = None
        self._build(robot)

    def _build(self, robot: RobotDescription) -> None:
        self._mask_table, self._contacts = MaskTable(), ContactReader(self.client)
        self._places = PlaceTree(self.spec, self.body)
        model = build.load_robot(self.client, robot)
        self._arm = model
        self._mask_table.add(robot.name, model)
        self._contacts.add(robot.name, model)
        self.room = build.load_room(self.client, self._places.carry)
        for body in self.room.values():
            self._register(body)
        self._mask_table.begin_objects()
        room_ids = {name: self._mask_table.first_id(body.model) for name, body in self.room.items()}
        self.renderer = Renderer(self.client, self.room, room_ids, self._mask_table.table, hardware=self.client.hardware)
        self.bodies: dict[str, Body] = {}
        self._spawned: dict[str, BodySpec] = {}
        for spec in self.spec.body:
            self._load(spec)
        for joint in self.spec.joint:
            self.joint(joint.name).configure(joint)
        self._springs = [j for body in self.bodies.values() for j in body.joints.values() if j.has_spring]
        self._places.place_bodies()
        self.robot = SimRobot(model, robot, self._contacts, self.timestep, self._substeps)
        self.wardrobe = Wardrobe(self.renderer, model, self.bodies, self.room)
        self.tuning = Tuning(self.robot)
        self.gripper = SimGripper(self.robot, self.body, lambda: tuple(self.bodies.values()))

    def _load(self, spec: BodySpec) -> Body:
        body = build.load_body(self.client, spec, self.spec.file, self._places.carry)
        if body.joints:
            build.share_island(self._arm, body)
        self.bodies[spec.name] = body
        self._places.hang(spec)
        self._register(body)
        return body

    def _register(self, body: Body) -> None:
        self._mask_table.add(body.name, body.model)
        self._contacts.add(body.name, body.model)

    # Finding things --------------------------------------------------------------------------------------------------

    def body(self, name: str) -> Body:
        """Return a body of the scene or the room.

        Raises:
            UnknownName: There is none of that name.
        """
        body = self.bodies.get(name) or self.room.get(name)
        if body is None:
            raise UnknownName("body of this scene", name, (*self.bodies, *self.room))
        return body

    def joint(self, name: str) -> ObjectJoint:
        """Return the joint called `<body>/<joint>`."""
        body, _, joint = name.partition("/")
        if body not in self.bodies or joint not in self.bodies[body].joints:
            known = [f"{b.name}/{j}" for b in self.bodies.values() for j in b.joints]
            raise UnknownName("joint of this scene", name, known)
        return self.bodies[body].joints[joint]

    def frame(self, name: str) -> Frame:
        """Return a frame, region, sensor or waypoint, or the root."""
        return self._places.frame(name)

    def region(self, name: str) -> Region:
        """Return a region of the scene."""
        return self._places.frame_of_kind(name, Region, "region")

    def sensor(self, name: str) -> Sensor:
        """Return a sensor of the scene."""
        return self._places.frame_of_kind(name, Sensor, "sensor")

    @property
    def frames(self) -> Mapping[str, Frame]:
        """All frames, regions, sensors and waypoints, and the root, by name."""
        return self._places.frames

    @property
    def root(self) -> Frame:
        """The frame that holds the whole task."""
        return self._places.frame(ROOT)

    def placement(self, name: str) -> pin.SE3:
        """Return T_world_x of a body, a link, a frame, `root` or `world`."""
        return self._places.placement(name)

    @property
    def masks(self) -> Mapping[int, str]:
        """Mask id -> name: robot and room below 61, task objects from 61 in the order of the scene file."""
        return dict(self._mask_table.names)

    # Time ------------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._ticks * self.control_dt

    @property
    def ticks(self) -> int:
        """Control ticks since the world was built."""
        return self._ticks

    def set_ticks(self, ticks: int) -> None:
        """Set the clock."""
        self._ticks = ticks

    def step(self) -> None:
        """Advance one control tick."""
        self.end_building()
        identifier = self.client.id
        self.robot.begin_tick()
        self.gripper.begin_tick()
        for substep in range(self._substeps):
            for command in self.on_physics:
                command()
            self.robot.drive(substep)
            self.gripper.drive(substep)
            for joint in self._springs:
                joint.pull(self.timestep)
            bullet.stepSimulation(physicsClientId=identifier)
        self._ticks += 1
        self.robot.forget_measurements()
        for callback in self.on_step:
            callback()

    # Changing the scene ----------------------------------------------------------------------------------------------

    def place_root(self, pose: PoseLike) -> None:
        """Move the root to a pose (7,), and everything that hangs on it; joints stay, velocities become zero."""
        self.root.set_pose(pose)

    def add_body(self, name: str, spec: BodySpec) -> Body:
        """Add a body to the running world; restoring an older state removes it.

        Args:
            name: Name that is not in use.
            spec: What to load and where; its own name is replaced by `name`.
        """
        if name in self.bodies or name in self.room or self._places.knows(name):
            raise RlbenchPinError(f"The name '{name}' is in use. Choose another for the new body.")
        spec = spec.model_copy(update={"name": name})
        body = self._load(spec)
        self._spawned[name] = spec
        self._places.place_body(name)
        return body

    def remove_body(self, name: str) -> None:
        """Remove a body that `add_body` made.

        Raises:
            RlbenchPinError: The body belongs to the scene file.
        """
        body = self.body(name)
        if name not in self._spawned:
            raise RlbenchPinError(f"'{name}' belongs to the scene file; only bodies made by add_body can be removed.")
        if name in self.gripper.grasped:
            self.gripper.release()
        self._close_gap(name)
        del self.bodies[name]
        self._places.unhang(name)
        self._mask_table.remove(body.model)
        self._contacts.remove(body.model.uid)
        bullet.removeBody(body.model.uid, physicsClientId=self.client.id)

    def _close_gap(self, name: str) -> None:
        """Forget a run-time body; the last one takes its place, as in PyBullet's own list, by whose order states are restored."""
        names = list(self._spawned)
        last = names.pop()
        order = [last if n == name else n for n in names]
        self._spawned = {n: self._spawned[n] for n in order}

    @property
    def spawned(self) -> Mapping[str, BodySpec]:
        """Bodies added at run time, in order."""
        return dict(self._spawned)

    # Asking ----------------------------------------------------------------------------------------------------------

    def contacts(self, body: str | None = None, other: str | None = None) -> tuple[Contact, ...]:
        """Return the contact points of the last physics step: all, those of one body, or those between two."""
        return self._contacts.read(self._uid(body), self._uid(other))

    def max_penetration(self) -> float:
        """Return how deep the deepest contact is [m]; 0 when nothing overlaps."""
        return self._contacts.deepest()

    def _uid(self, name: str | None) -> int | None:
        if name is None:
            return None
        return self.robot.model.uid if name == self.robot.description.name else self.body(name).model.uid

    def snapshot(self) -> WorldSnapshot:
        """Return names, shapes, poses and joint values at this instant."""
        return capture(self.room.values(), self.bodies.values(), self.robot, self.gripper)

    def render(
        self,
        camera: CameraView,
        *,
        rgb: bool = True,
        depth: bool = True,
        mask: bool = True,
        shadows: bool | ShadowMap = False,
    ) -> Pictures:
        """Take pictures; see `Renderer.render`."""
        return self.renderer.render(camera, rgb=rgb, depth=depth, mask=mask, shadows=shadows)

    # Going back ------------------------------------------------------------------------------------------------------

    @property
    def origin(self) -> WorldState:
        """The world as it was when its building ended: when that was said, at its first step, or when it was first saved."""
        self.end_building()
        assert self._origin is not None
        return self._origin

    def end_building(self) -> None:
        """Take the present state as the origin, unless there is one."""
        if self._origin is None:
            self.client.end_building()
            self._origin = state.save(self)

    def save(self) -> WorldState:
        """Remember this instant exactly, in memory; freed with the returned object."""
        self.end_building()
        return state.save(self)

    def restore(self, saved: WorldState) -> None:
        """Go back to a remembered instant of this world, exactly."""
        state.restore(self, saved)

    def build_again(self) -> None:
        """Go back to the origin, in a physics server without a past; saved states stay good.

        What follows is the same to the last bit whatever was simulated before, which `restore` cannot promise where many pieces
        touch: PyBullet looks at their contacts in an order that depends on earlier ones. Bodies, joints and frames stay the
        same objects; textures and changes of the physics are kept.

        With EGL this only restores the origin, because PyBullet's EGL plugin never frees the textures of what is thrown away.
        """
        if self.client.hardware:
            self.restore(self.origin)
            return
        state.build_again(self)

    def arrays(self, exact: bool = True) -> dict[str, np.ndarray]:
        """Return this instant as plain arrays that another process can continue from.

        Args:
            exact: To the last bit; otherwise without contact forces, smaller, and with the same bytes in every process.
        """
        self.end_building()
        return portable.to_arrays(self, exact)

    def set_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Continue from `arrays` of a world with the same scene and robot."""
        self.end_building()
        portable.from_arrays(self, arrays)

    # End -------------------------------------------------------------------------------------------------------------

    @property
    def closed(self) -> bool:
        """True after `close`."""
        return self.client.closed

    def close(self) -> None:
        """Free the physics server; the world cannot be used afterwards."""
        self._finalizer()

    def __enter__(self) -> World:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        self.close()


def _whole_ratio(control_dt: float, timestep: float) -> int:
    ratio = round(control_dt / timestep) if timestep > 0.0 else 0
    if ratio < 1 or abs(ratio * timestep - control_dt) > 1e-9:
        raise ValueError(f"A control tick of {control_dt} s is not a whole number of physics steps of {timestep} s.")
    return ratio
