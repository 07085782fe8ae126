"""A running physics world: one scene, one robot, one PyBullet server."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from types import TracebackType

import numpy as np
import pinocchio as pin

from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.scene.spec import ROOT, BodySpec, SceneSpec
from rlbench_pin.sim import portable, state
from rlbench_pin.sim.arm.gripper import SimGripper
from rlbench_pin.sim.arm.robot import SimRobot
from rlbench_pin.sim.bodies.body import Body
from rlbench_pin.sim.bodies.joint import ObjectJoint
from rlbench_pin.sim.capture import capture
from rlbench_pin.sim.checks import whole_ratio
from rlbench_pin.sim.client import open_client
from rlbench_pin.sim.contacts import Contact
from rlbench_pin.sim.contents import Contents
from rlbench_pin.sim.dynamics_overrides import DynamicsOverrides
from rlbench_pin.sim.frame import Frame, Region
from rlbench_pin.sim.places import PlaceTree
from rlbench_pin.sim.render.camera import CameraView, Pictures
from rlbench_pin.sim.render.egl import RendererName
from rlbench_pin.sim.render.renderer import Renderer
from rlbench_pin.sim.render.shadows import ShadowMap
from rlbench_pin.sim.render.texture_overrides import TextureOverrides
from rlbench_pin.sim.resting import Resting
from rlbench_pin.sim.sensor import Sensor
from rlbench_pin.sim.state import WorldState
from rlbench_pin.spatial import PoseLike
from rlbench_pin.values import as_flag, as_record, as_whole


class World:
    """Everything that is simulated; a context manager that frees the physics server.

    Args:
        spec: What the scene file says.
        robot: The arm behind the table.
        timestep: Physics step [s].
        control_dt: Control tick [s], a whole number of physics steps.
        renderer: What draws moving things: `cpu`, `egl`, or `auto` for EGL where there is one.

    Attributes:
        spec: The scene it was built from.
        robot: Arm and fingers.
        gripper: The hand and what it holds.
        bodies: Bodies of the scene and those added at run time, by name.
        room: Table, floor and walls, by name.
        renderer: Takes the pictures; its `lighting` may be replaced.
        texture_overrides: Textures over the colours of robot, bodies and room.
        dynamics_overrides: Scaled masses, friction, damping and gains.
        resting: Bodies that sleep until something comes near them.
        on_physics: Called before every physics step; may command the arm.
        keepers: What others keep beside the world and want saved and restored with it.
        client: The physics server, for modules of this folder only.
        saved_states: States that can still be restored; one is freed when nothing refers to it any more.
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
        self._substeps, self._ticks = whole_ratio(control_dt, timestep), 0
        self.on_physics: list[Callable[[], None]] = []
        self.keepers: list[state.StateKeeper] = []
        self.client = open_client(timestep, renderer)
        self._finalizer = weakref.finalize(self, self.client.close)
        self.saved_states: weakref.WeakSet[WorldState] = weakref.WeakSet()
        self._origin: WorldState | None = None
        self._build(robot)

    def _build(self, robot: RobotDescription) -> None:
        self._contents = contents = Contents(self.client, self.spec, robot)
        self.bodies, self.room, self._places = contents.bodies, contents.room, contents.places
        self.resting = Resting(self.client, self.bodies, self.room)
        self._springs = contents.joints_with_springs()
        self.renderer = Renderer(self.client, self.room, contents.room_ids, contents.masks.table, contents.looks)
        self.robot = SimRobot(contents.robot, robot, contents.contacts, self.timestep, self._substeps)
        self.texture_overrides = TextureOverrides(self.renderer, contents.robot, self.bodies, self.room)
        self.dynamics_overrides = DynamicsOverrides(self.robot)
        self.gripper = SimGripper(self.robot, self.body, lambda: tuple(self.bodies.values()))

    # Lookup ----------------------------------------------------------------------------------------------------------

    def body(self, name: str) -> Body:
        """Return a body of the scene or the room.

        Raises:
            UnknownName: There is none of that name.
        """
        return self._contents.body(name)

    def joint(self, name: str) -> ObjectJoint:
        """Return the joint called `<body>/<joint>`."""
        return self._contents.joint(name)

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
    def places(self) -> PlaceTree:
        """The tree of parents and children."""
        return self._places

    @property
    def masks(self) -> Mapping[int, str]:
        """Mask id -> name: robot and room below 61, task objects from 61 in the order of the scene file."""
        return dict(self._contents.masks.names)

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
        self._ticks = as_whole(ticks, "ticks", least=0)

    def step(self) -> None:
        """Advance one control tick."""
        self.end_building()
        self.robot.begin_tick()
        self.gripper.begin_tick()
        for substep in range(self._substeps):
            for command in self.on_physics:
                command()
            self.robot.drive(substep)
            self.gripper.drive(substep)
            for joint in self._springs:
                joint.pull(self.timestep)
            self.resting.step()
        self.resting.end_tick()
        self._ticks += 1
        self.robot.forget_measurements()

    # Changing the world ----------------------------------------------------------------------------------------------

    def place_root(self, pose: PoseLike) -> None:
        """Move the root to a pose (7,), and all its descendants; joints stay, velocities become zero."""
        self.root.set_pose(pose)

    def add_body(self, name: str, spec: BodySpec) -> Body:
        """Add a body to the running world; restoring an older state removes it.

        Args:
            name: Name that is not in use.
            spec: What to load and where; its own name is replaced by `name`.
        """
        return self._contents.add(name, spec)

    def remove_body(self, name: str) -> None:
        """Remove a body that `add_body` made.

        Raises:
            RlbenchPinError: The body belongs to the scene file.
        """
        if name in self.gripper.grasped and name in self._contents.spawned:
            self.gripper.release()
        self.dynamics_overrides.forget(self.body(name).model)
        self.texture_overrides.clear_body(name)
        self._contents.remove(name)

    @property
    def spawned(self) -> Mapping[str, BodySpec]:
        """Bodies added at run time, in order."""
        return self._contents.spawned

    # Queries ---------------------------------------------------------------------------------------------------------

    def contacts(self, body: str | None = None, other: str | None = None) -> tuple[Contact, ...]:
        """Return the contact points of the last physics step: all, those of one body, or those between two."""
        first, second = (None if name is None else self._contents.model(name).uid for name in (body, other))
        return self._contents.contacts.read(first, second)

    def max_penetration(self) -> float:
        """Return how deep the deepest contact is [m]; 0 when nothing overlaps."""
        return self._contents.contacts.deepest()

    def snapshot(self) -> WorldSnapshot:
        """Return names, shapes, poses and joint values at this instant."""
        return capture(self.room.values(), self.bodies.values(), self.robot, self.gripper)

    def render(
        self, camera: CameraView, *, rgb: bool = True, depth: bool = True, mask: bool = True, shadows: bool | ShadowMap = False
    ) -> Pictures:
        """Take pictures; see `Renderer.render`."""
        return self.renderer.render(camera, rgb=rgb, depth=depth, mask=mask, shadows=shadows)

    # Saving and restoring --------------------------------------------------------------------------------------------

    @property
    def origin(self) -> WorldState:
        """The world as it was when its building ended: at `end_building`, at the first step, or at the first save."""
        self.end_building()
        assert self._origin is not None
        return self._origin

    def end_building(self) -> None:
        """Take the present state as the origin, unless there is one."""
        if self._origin is None:
            self.client.end_building()
            self._origin = state.save(self)

    def save(self, portable: bool = False) -> WorldState:
        """Remember this instant exactly, in memory; freed with the returned object. A `portable` one can be pickled."""
        self.end_building()
        return state.save(self, as_flag(portable, "portable"))

    def restore(self, saved: WorldState) -> None:
        """Go back to a remembered instant of this world, exactly."""
        state.restore(self, as_record(saved, WorldState, "saved"))

    def build_again(self) -> None:
        """Go back to the origin, in a physics server that was emptied and built again; saved states stay valid.

        What follows is the same to the last bit whatever was simulated before, which `restore` cannot promise where many pieces
        touch: PyBullet looks at their contacts in an order that depends on earlier ones. Bodies, joints, frames, textures and
        changes of the physics are kept.

        With EGL this only restores the origin, because PyBullet's EGL plugin never frees the textures of what is thrown away.
        """
        if self.client.hardware:
            self.restore(self.origin)
            return
        state.build_again(self)

    def arrays(self, exact: bool = True) -> dict[str, np.ndarray]:
        """Return this instant as arrays that another process can continue from: exactly, or without contacts and smaller."""
        self.end_building()
        return portable.to_arrays(self, as_flag(exact, "exact"))

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
