"""A running physics world: one scene, one robot, one PyBullet server."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Mapping
from types import TracebackType

import numpy as np

from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import state
from rlbench_pin.sim.arm.delay import CommandDelay
from rlbench_pin.sim.client import PhysicsClient, RendererName, open_client
from rlbench_pin.sim.contents import Contents
from rlbench_pin.sim.render.camera import CameraView, Images
from rlbench_pin.sim.render.lighting import ShadowMap
from rlbench_pin.sim.state import Physics, WorldState
from rlbench_pin.values import as_flag, as_number, as_record, as_seed, as_whole, whole_ratio

MAX_LATENCY = 100
"""Control ticks by which commands of the arm can be late at most."""


class World(Contents):
    """The simulated world; a context manager that frees the physics server.

    Args:
        spec: The scene.
        robot: The arm behind the table.
        timestep: Physics step [s].
        control_dt: Control tick [s], a whole number of physics steps.
        renderer: Renderer of moving bodies: `cpu`, `egl`, or `auto` for EGL if it is available.
        replaced: World that is closed first. Without EGL its physics server is used again, which is faster than a new one.

    Attributes:
        spec: The scene of the world.
        robot: Arm and fingers.
        gripper: The gripper and the bodies that it holds.
        bodies: Bodies of the scene and those added at run time, by name.
        room: Table, floor and walls, by name.
        places: The tree of parents and children.
        renderer: Renders the images; its `lighting` may be replaced.
        texture_overrides: Textures over the colours of robot, bodies and room.
        dynamics_overrides: Scaled masses, friction, damping and gains.
        resting: Sleeping bodies.
        on_physics: Called before every physics step; may command the arm.
        command_delay: Delay of the commands of the arm; None without delay. See `delay_commands`.
        keepers: Objects whose states are saved and restored with the world.
        client: The physics server, for modules of this folder only.
        saved_states: States that can be restored; a state is freed when it is no longer referenced.
    """

    def __init__(
        self,
        spec: SceneSpec,
        robot: RobotDescription,
        *,
        timestep: float = 1.0 / 240.0,
        control_dt: float = 0.05,
        renderer: RendererName = "cpu",
        replaced: World | None = None,
    ) -> None:
        self.timestep, self.control_dt = timestep, control_dt
        self._substeps = whole_ratio(control_dt, timestep)
        self.on_physics: list[Callable[[], None]] = []
        client = open_client(timestep, renderer) if replaced is None else _client_after(replaced, timestep)
        self._finalizer = weakref.finalize(self, client.close)
        self.command_delay: CommandDelay | None = None
        self.saved_states: weakref.WeakSet[WorldState] = weakref.WeakSet()
        self._origin: WorldState | None = None
        super().__init__(client, spec, robot, timestep, self._substeps)
        self._springs = [joint for body in self.bodies.values() for joint in body.joints.values() if joint.has_spring]

    # Time ------------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._ticks * self.control_dt

    def step(self) -> None:
        """Advance one control tick."""
        self.end_building()
        if self.command_delay is not None:
            self.command_delay.pass_on()
        self.robot.begin_tick()
        if self.command_delay is not None:
            self.command_delay.end_tick()
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

    @property
    def command_lost(self) -> bool:
        """Whether the command of the last tick is lost and never reaches the motors."""
        return self.command_delay is not None and self.command_delay.lost

    def delay_commands(self, latency: int = 0, loss: float = 0.0, seed: int = 0) -> None:
        """Delay commands of the arm's motors from now on, and lose some; without arguments there is no delay.

        Args:
            latency: Control ticks between a command and its arrival.
            loss: Probability that a command is lost on its way. The command before it then stays active for one more tick.
            seed: Seed of the losses.

        Raises:
            InvalidValue: An argument is not a number, or out of range.
        """
        latency, seed = as_whole(latency, "latency", least=0, most=MAX_LATENCY), as_seed(seed, "seed")
        loss = as_number(loss, "loss", least=0.0, most=1.0)
        self.keepers = [keeper for keeper in self.keepers if keeper is not self.command_delay]
        self.command_delay = CommandDelay(self.robot, latency, loss, seed) if latency or loss else None
        if self.command_delay is not None:
            self.keepers.append(self.command_delay)

    # Rendering -------------------------------------------------------------------------------------------------------

    def render(
        self,
        camera: CameraView,
        *,
        rgb: bool = True,
        depth: bool = True,
        mask: bool = True,
        shadows: bool | ShadowMap = False,
        antialiasing: bool = False,
    ) -> Images:
        """Render the images of one camera; see `Renderer.render`."""
        return self.renderer.render(camera, rgb=rgb, depth=depth, mask=mask, shadows=shadows, antialiasing=antialiasing)

    # Saving and restoring --------------------------------------------------------------------------------------------

    @property
    def origin(self) -> WorldState:
        """The state at the end of building: at `end_building`, at the first step, or at the first save."""
        self.end_building()
        assert self._origin is not None
        return self._origin

    def end_building(self) -> None:
        """Make the present state the origin, unless there is one."""
        if self._origin is None:
            self.client.end_building()
            self._origin = self._save(portable=False)

    def save(self, portable: bool = False) -> WorldState:
        """Return the exact present state, in memory; it is freed with the returned object. A `portable` one can be pickled."""
        self.end_building()
        return self._save(as_flag(portable, "portable"))

    def _save(self, portable: bool) -> WorldState:
        saved = state.save(self, portable)
        self.saved_states.add(saved)
        return saved

    def restore(self, saved: WorldState) -> None:
        """Restore a saved state of this world exactly."""
        state.restore(self, as_record(saved, WorldState, "saved"))

    def build_again(self) -> None:
        """Restore the origin in a physics server that is emptied and built again; saved states stay valid.

        The continuation is bit-identical after any earlier simulation. `restore` does not guarantee that where many bodies touch,
        because the order of PyBullet's contacts depends on earlier ones. Bodies, joints, frames, textures and overrides of the
        dynamics are kept.

        With EGL this only restores the origin, because PyBullet's EGL plugin never frees textures.
        """
        if self.client.hardware:
            self.restore(self.origin)
            return
        state.build_again(self, self.origin, self.saved_states)

    def arrays(self, exact: bool = True) -> dict[str, np.ndarray]:
        """Return the present state as arrays for another process: exact, or smaller and without contacts."""
        self.end_building()
        return state.to_arrays(self, as_flag(exact, "exact"))

    def set_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Continue from `arrays` of a world with the same scene and robot."""
        self.end_building()
        state.from_arrays(self, arrays)

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


def _client_after(replaced: World, timestep: float) -> PhysicsClient:
    """Close a world, and return a client for another one, with the same renderer."""
    for saved in replaced.saved_states:
        if isinstance(saved.physics, Physics):
            saved.physics.forget()
    replaced.renderer.forget()
    if not replaced.client.hardware:
        return PhysicsClient(timestep, server=replaced.client.leave())
    replaced.close()
    return PhysicsClient(timestep, hardware=True)
