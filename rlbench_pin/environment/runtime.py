"""The runtime: one world, one task, one planner, stepped together."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np

from rlbench_pin.environment.listener import Listener, Listeners, timed_ticks
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.observations.observe import Observer
from rlbench_pin.environment.observations.placing import CameraPlaces, Cameras
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.observation import Observation
from rlbench_pin.planning.planner import MotionPlanner, PlannerConfig
from rlbench_pin.planning.requests import FORGIVEN
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import RendererName, World
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray
from rlbench_pin.tasks import Task, task_scene
from rlbench_pin.tasks.task import Verdict

TIP_WORKSPACE = np.array([[-0.274, -0.655, TABLE_HEIGHT], [0.774, 0.655, TABLE_HEIGHT + 1.0]])
"""Lowest and highest corner of the box that tip targets must lie in [m]."""
OVERSHOOT = 0.05
"""How far motors may carry a joint beyond its limit [rad]."""

BoundT = TypeVar("BoundT", covariant=True)
RuntimeT = TypeVar("RuntimeT", bound="Runtime")


class Bindable(Protocol[BoundT]):
    """Something that keeps data of its own for every runtime, such as an action mode its solver."""

    def bind(self, runtime: Runtime) -> BoundT:
        """Make the data for one runtime."""
        ...


@dataclass(frozen=True)
class RuntimeState:
    """Everything needed to continue an episode exactly from one instant."""

    world: Any
    task: Any
    variation: int
    instructions: tuple[str, ...]
    noise: Mapping[str, Any]
    planning: int
    """Seed of the generators of plans."""


class Runtime:
    """What action modes and demonstrations work on.

    Attributes:
        world: The simulated world.
        robot: Arm and fingers of the world.
        gripper: Hand of the world.
        instructions: Sentences that say what to do in the present episode.
        task: The task that is running.
        model: Analytic model of the arm.
        planner: Motion planner over `model`.
        attach_grasped_objects: Whether closing the hand fixes grasped bodies to it, unless the gripper mode says otherwise.
        listeners: Called for ticks, observations and legs; see `listening`.
    """

    def __init__(
        self,
        world: World,
        task: Task,
        robot: RobotDescription,
        model: RobotModel,
        planner: MotionPlanner,
        config: ObservationConfig,
        attach_grasped_objects: bool = True,
        camera_places: CameraPlaces | None = None,
    ) -> None:
        self.world, self.task, self.description, self.model, self.planner = world, task, robot, model, planner
        self.robot, self.gripper = world.robot, world.gripper
        self.observer = Observer(world, model, config, camera_places)
        self.attach_grasped_objects = attach_grasped_objects
        self.variation = 0
        self._planning_seed = 0
        self.instructions: tuple[str, ...] = ()
        self.noise_rng = np.random.default_rng(0)
        self.listeners = Listeners()
        self._parts: list[Callable[[], None]] = []
        self._callbacks: list[Callable[[], None]] = []
        self._command_filter: Callable[[Runtime], None] | None = None
        self._verdict: Verdict | None = None
        self._bound: dict[int, tuple[object, Any]] = {}

    def begin(self, variation: int, planning: np.random.Generator, noise: np.random.Generator) -> None:
        """Take over what an episode is given.

        Args:
            variation: Variation of the task.
            planning: Draws the seed of the generators of plans and of inverse kinematics.
            noise: Generator of observation noise.
        """
        self.variation, self.noise_rng = variation, noise
        self.instructions = ()
        self._planning_seed = int(planning.integers(2**63))

    @property
    def planning_rng(self) -> np.random.Generator:
        """A generator for one plan. All plans of an episode begin with the same draws: asked again, a motion comes out alike."""
        return np.random.default_rng(self._planning_seed)

    @property
    def measured_start(self) -> FloatArray:
        """Where a motion begins: the measured joint positions (n,), [rad], at the limit where motors have overshot one a little.

        Positions farther outside than `OVERSHOOT`, where only a reset can put the arm, stay as they are: planners refuse them.
        """
        q, limits = self.robot.joint_positions, self.model.limits
        if limits.contains(q, FORGIVEN) or not limits.contains(q, OVERSHOOT):
            return q
        return np.clip(q, limits.lower, limits.upper)

    def instruct(self, instructions: Sequence[str]) -> None:
        """Take over the sentences that say what to do in this episode."""
        self.instructions = tuple(instructions)

    @property
    def cameras(self) -> Cameras:
        """The cameras by name: `cameras["front"].set_pose(...)` puts one elsewhere."""
        return self.observer.cameras

    def bound(self, mode: Bindable[BoundT]) -> BoundT:
        """Return what `mode` keeps for this runtime; it is bound when first asked for."""
        if id(mode) not in self._bound:
            self._bound[id(mode)] = (mode, mode.bind(self))  # with the mode, so that no other gets its id
        bound: BoundT = self._bound[id(mode)][1]
        return bound

    def call_each_tick(self, part: Callable[[], None]) -> None:
        """Call a part of the environment after every control tick, before the callbacks of users; nothing removes it."""
        self._parts.append(part)

    def register_step_callback(self, callback: Callable[[], None] | None) -> None:
        """Call `callback` after every control tick, beside those registered before, once however often it is registered.

        Args:
            callback: Takes no argument; None removes all.
        """
        if callback is None:
            self._callbacks.clear()
        elif callback not in self._callbacks:
            self._callbacks.append(callback)

    def remove_step_callback(self, callback: Callable[[], None]) -> None:
        """Undo `register_step_callback`; nothing happens when it is not registered."""
        if callback in self._callbacks:
            self._callbacks.remove(callback)

    def step(self) -> None:
        """Advance one control tick: physics, then the task's own step, the callbacks, and the verdict on an action."""
        if self._command_filter is not None:
            self._command_filter(self)
        self.world.step()
        self.task.step()
        for callback in (*self._parts, *self._callbacks):
            callback()
        if self._verdict is not None:
            self._verdict.ask()

    @property
    def over(self) -> bool:
        """Whether a tick of the present action has ended the episode; then the rest of the action is left out."""
        return self._verdict is not None and self._verdict.over

    @contextmanager
    def judging(self) -> Iterator[Verdict]:
        """Ask the task after every tick of a block, one action, whether the goal is reached and whether the episode is over."""
        before, self._verdict = self._verdict, Verdict(self.task)
        try:
            yield self._verdict
            self._verdict.ask_at_least_once()
        finally:
            self._verdict = before

    @contextmanager
    def filtering(self, command_filter: Callable[[Runtime], None]) -> Iterator[None]:
        """Let `command_filter` check the motor command before every tick, for the duration of a block."""
        before, self._command_filter = self._command_filter, command_filter
        try:
            yield
        finally:
            self._command_filter = before

    def drive_to(self, target: FloatArray) -> None:
        """Move the arm towards joint positions `target` [rad] for one tick, then hold where it is."""
        self.robot.set_position_targets(target)
        self.step()
        self.hold()

    def place_task(self, rng: np.random.Generator) -> None:
        """Put the task at a random place on the table, drawn from `rng`; raises BoundaryError when there is none."""
        self.task.place(rng)

    def hold(self) -> None:
        """Keep the arm where it is now."""
        self.robot.set_position_targets(self.robot.joint_positions)

    def get_observation(self) -> Observation:
        """Observe without stepping."""
        with self.listeners.observe():
            return self.observer.observe(self.task, self.variation, self.noise_rng, self.instructions)

    @contextmanager
    def listening(self, listener: Listener) -> Iterator[None]:
        """Call `listener` for plans, control ticks, observations and legs, for the duration of a block."""
        planner, world = self.planner, self.world
        with planner.listeners.including(listener), self.listeners.including(listener), timed_ticks(world, listener.on_tick):
            yield

    def refresh_planner(self) -> None:
        """Give the planner a snapshot of the present world."""
        self.planner.update(self.world.snapshot())

    def touching(self) -> tuple[str, ...]:
        """Names of bodies that the arm touches and does not hold."""
        held = set(self.gripper.grasped)
        return tuple(name for name in self.robot.touching() if name not in held)

    def check_target_in_workspace(self, position: FloatArray) -> None:
        """Raise InvalidActionError when `position` (3,) [m] is not strictly inside the workspace box."""
        for axis, letter in enumerate("xyz"):
            low, high = TIP_WORKSPACE[:, axis]
            if not low < position[axis] < high:
                raise InvalidActionError(
                    f"The target has {letter} = {position[axis]:.4f} m, outside the workspace: "
                    f"{letter} must lie between {low} and {high} m. Choose a target inside.",
                    "outside the workspace",
                )

    def save(self, *, portable: bool = False) -> RuntimeState:
        """Return the present state; only a `portable` one can be pickled."""
        world, task, noise = self.world.save(portable), self.task.state(), self.noise_rng.bit_generator.state
        return RuntimeState(world, task, self.variation, self.instructions, noise, self._planning_seed)

    def restore(self, state: RuntimeState) -> None:
        """Go back to `state`, exactly."""
        self.world.restore(state.world)
        self.task.set_state(state.task)
        self.variation, self.instructions = state.variation, state.instructions
        self.noise_rng.bit_generator.state = state.noise
        self._planning_seed = state.planning


class EmptyTable(Task):
    """No task: the arm alone at an empty table."""

    def init_task(self) -> None:
        """Nothing."""


def build_runtime(
    task: type[Task],
    model: RobotModel,
    config: ObservationConfig,
    *,
    planning: PlannerConfig | None = None,
    attach_grasped_objects: bool = True,
    renderer: RendererName = "cpu",
    camera_places: CameraPlaces | None = None,
    kind: type[RuntimeT] = Runtime,  # type: ignore[assignment]
) -> RuntimeT:
    """Build the world of a task and set the task up.

    Args:
        task: What the world is for; `EmptyTable` has no scene file.
        model: The arm.
        config: What observations contain.
        planning: Settings of the planner.
        attach_grasped_objects: As in `Runtime`.
        renderer: Who draws pictures.
        camera_places: Where cameras stand that were put elsewhere; shared with other runtimes.
        kind: `Runtime`, or a subclass of it.
    """
    spec = SceneSpec(format=1) if task is EmptyTable else task_scene(task)
    world = World(spec, model.description, renderer=renderer)
    try:
        running = task(world)
        running.init_task()
        planner = MotionPlanner(model, planning)
        return kind(world, running, model.description, model, planner, config, attach_grasped_objects, camera_places)
    except BaseException:
        world.close()
        raise
