"""The runtime: one world, one task, one planner, stepped together."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from itertools import islice
from typing import Any, TypeVar

import numpy as np

from rlbench_pin.control.compliant import CompliantFollowing
from rlbench_pin.control.following import TrajectoryTracker
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.observations.observe import Cameras, Observer
from rlbench_pin.environment.other_bodies import resized, with_models
from rlbench_pin.errors import InvalidActionError, NoShapedReward
from rlbench_pin.observation import Observation
from rlbench_pin.planning.kinematics import JOINT_LIMIT_TOLERANCE
from rlbench_pin.planning.plan import ListenerList, Plan, PlanningListener
from rlbench_pin.planning.planner import MotionPlanner, PlannerConfig
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import RendererName, World
from rlbench_pin.spatial import TABLE_HEIGHT, FloatArray
from rlbench_pin.tasks import Task, Waypoint, task_scene

TIP_WORKSPACE = np.array([[-0.274, -0.655, TABLE_HEIGHT], [0.774, 0.655, TABLE_HEIGHT + 1.0]])
"""Lowest and highest corner of the box that must contain tip targets [m]."""
OVERSHOOT = 0.05
"""Maximum overshoot of a joint beyond its limit [rad]."""

KeptT = TypeVar("KeptT")
RuntimeT = TypeVar("RuntimeT", bound="Runtime")
TickFunction = Callable[[], None]


class Listener(PlanningListener):
    """Receives the events of a runtime without changing it. The methods do nothing: override those that you need."""

    def on_tick(self, seconds: float) -> None:
        """Handle a control tick that `Runtime.step` simulated in `seconds` [s] of process time."""

    def on_observe(self, seconds: float) -> None:
        """Handle an observation that was made in `seconds` [s] of process time."""

    def on_segment(self, waypoint: Waypoint, plan: Plan) -> None:
        """Handle the motion to a waypoint of a demonstration, after its planning and before its first tick."""


class Listeners(ListenerList[Listener]):
    """The listeners of one runtime."""

    def observe(self) -> AbstractContextManager[None]:
        """Report the block as one observation."""
        return self.timed(lambda listener, seconds, _: listener.on_observe(seconds))

    def segment(self, waypoint: Waypoint, plan: Plan) -> None:
        """Report the motion to a waypoint before its first tick."""
        for listener in self._listeners:
            listener.on_segment(waypoint, plan)


@dataclass(frozen=True)
class RefusedOpening:
    """The reason why `SafeArm` did not open the fingers: a pair could come nearer than its minimum distance."""

    pair: tuple[str, str]
    """Names of the pair that could come too near."""
    distance: float
    """Smallest distance that the opening could lead to [m]; 0 or below is contact."""
    minimum: float
    """Smallest distance allowed [m]."""

    def __str__(self) -> str:
        """Return the reason as a sentence, with the next step."""
        return (
            f"The fingers did not open: {self.pair[0]} could come within {1e3 * self.distance:.1f} mm of {self.pair[1]}; "
            f"the minimum is {1e3 * self.minimum:.1f} mm. Move the gripper away first."
        )


class ActionResult:
    """Success and end of the episode during one action; the first tick that ends the episode counts.

    Args:
        task: The running task.

    Attributes:
        success: Whether the goal was reached.
        over: Whether the episode has ended, by success or by the fail list.
        refused_opening: Reason why the fingers did not open, if the action requires it; None otherwise.
    """

    def __init__(self, task: Task) -> None:
        self._task, self.evaluated = task, False
        self.success = self.over = False
        self.refused_opening: RefusedOpening | None = None

    def evaluate(self) -> None:
        """Evaluate all conditions of the task at the end of a tick; the result of an ended episode does not change."""
        if self.over:
            return
        self.evaluated = True
        success, over = self._task.success()
        self.success, self.over = bool(success), bool(over)

    def reward(self, shaped: bool = False) -> float:
        """Return 1 if the goal was reached, else 0; with `shaped`, return the shaped reward of the task in the present state.

        Raises:
            NoShapedReward: The task has no shaped reward (also a RuntimeError).
        """
        if not shaped:
            return float(self.success)
        reward = self._task.reward()
        if reward is None:
            raise NoShapedReward(self._task.get_name())
        return float(reward)


@dataclass(frozen=True)
class RuntimeState:
    """A complete state of an episode, from which it continues exactly."""

    world: Any
    task: Any
    variation: int
    instructions: tuple[str, ...]
    noise: Mapping[str, Any]
    planning: int
    """Seed of the generators of plans."""
    build: int = 0
    """Number of changes of bodies before this state; see `Runtime.build_again`."""


class Runtime:
    """World, task, model and planner: the interface for action modes and demonstrations.

    Attributes:
        world: The simulated world.
        robot: Arm and fingers of the world.
        gripper: Gripper of the world.
        instructions: Instructions of the present episode.
        task: The running task.
        model: Analytic model of the arm.
        planner: Motion planner over `model`.
        sizes: Scale factor of each body whose size differs from the scene file; see `build_again`.
        models: URDF file of each body whose model differs from the scene file; see `build_again`.
        build: Number of changes of bodies.
        listeners: Receivers of ticks, observations and segments; see `listening`.
        before_tick: Functions that `step` calls before each control tick, in order.
        after_tick: Functions that `step` calls after each control tick, in order: listeners, the step of the task, randomization,
            callbacks of users, and during an action the evaluation of success.
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
        camera_places: dict[str, FloatArray] | None = None,
    ) -> None:
        self.description, self.model, self.planner = robot, model, planner
        self._config, self._camera_places, self._attaches = config, camera_places, attach_grasped_objects
        self.sizes: Mapping[str, float] = {}
        self.models: Mapping[str, str] = {}
        self.build = 0
        self._use_world(world, task)
        self.variation = 0
        self._planning_seed = 0
        self.instructions: tuple[str, ...] = ()
        self.noise_rng = np.random.default_rng(0)
        self.listeners = Listeners()
        self.before_tick: list[TickFunction] = []
        self.after_tick: list[TickFunction] = [lambda: self.task.step()]
        self._callbacks: list[TickFunction] = []
        self._result: ActionResult | None = None
        self._kept: dict[object, Any] = {}
        self._base, self._built = np.array(robot.base_pose), (model, planner)

    def _use_world(self, world: World, task: Task) -> None:
        self.world, self.task, self.robot, self.gripper = world, task, world.robot, world.gripper
        self.observer = Observer(world, self.model, self._config, self._camera_places)
        if not self._attaches:
            self.gripper.rely_on_friction()

    def build_again(self, sizes: Mapping[str, float] = {}, models: Mapping[str, str] = {}) -> None:
        """End the episode, and bring the world to its origin in an emptied physics server, as `World.build_again` does.

        If sizes or models differ from the present ones, `world`, `task`, `robot`, `gripper` and `observer` are replaced, and the
        arm is at the base pose of its description.

        Args:
            sizes: Scale factor of each body; other bodies have the size in the scene file.
            models: URDF file of each body; other bodies have the model in the scene file.
        """
        self.task.end_episode()
        if sizes == self.sizes and models == self.models:
            self.world.build_again()
            return
        kind = type(self.task)
        self.place_arm()
        scene = resized(with_models(task_scene(kind), models), sizes)
        world, task = _with_task(kind, World(scene, self.description, replaced=self.world))
        world.end_building()
        self._kept.clear()
        self.sizes, self.models, self.build = dict(sizes), dict(models), self.build + 1
        self._use_world(world, task)

    def place_arm(self, base: FloatArray | None = None) -> None:
        """Put the base of the arm at a pose (7,) in the world; None selects the pose in its description.

        `model` and `planner` are replaced to match.
        """
        own = np.array(self.description.base_pose)
        wanted = own if base is None else base
        if np.array_equal(wanted, self._base):
            return
        self._base = wanted
        if np.array_equal(wanted, own):
            self.model, self.planner = self._built
        else:
            self.model = RobotModel(self.description, wanted)
            self.planner = MotionPlanner(self.model, self.planner.config)
            self.planner.listeners = self._built[1].listeners
        self.observer.use_model(self.model)
        self._kept.clear()
        self.robot.place_base(wanted)

    def begin(self, variation: int, planning: np.random.Generator, noise: np.random.Generator) -> None:
        """Start an episode with its variation and its generators.

        Args:
            variation: Variation of the task.
            planning: Generator that draws the seed for plans and inverse kinematics.
            noise: Generator of observation noise.
        """
        self.variation, self.noise_rng = variation, noise
        self.instructions = ()
        if not np.array_equal(self._base, self.description.base_pose):
            self.robot.place_base(self._base)  # the world has just gone back to its origin
        self._planning_seed = int(planning.integers(2**63))

    @property
    def planning_rng(self) -> np.random.Generator:
        """Return a generator for one plan. All plans of an episode get the same draws, so that a repeated plan is equal."""
        return np.random.default_rng(self._planning_seed)

    @property
    def measured_start(self) -> FloatArray:
        """Return the start of a motion: the measured joint positions (n,) [rad], with small overshoots clipped to the limits.

        Positions beyond a limit by more than `OVERSHOOT` occur only after a reset. They stay unchanged, and planners reject them.
        """
        q, limits = self.robot.joint_positions, self.model.limits
        if limits.contains(q, JOINT_LIMIT_TOLERANCE) or not limits.contains(q, OVERSHOOT):
            return q
        return np.clip(q, limits.lower, limits.upper)

    def unpainted_bodies(self, role: str) -> list[str]:
        """Return the bodies of a role with the colours of the scene file; colours that the task sets have a meaning.

        Args:
            role: `manipulated` or `receiving`, as in scene files.
        """
        specs, before = (*self.world.spec.body, *self.world.spawned.values()), self.world.origin.logical.bodies
        named = [(spec.name, before.get(spec.name)) for spec in specs if spec.role == role and spec.name in self.world.bodies]
        return [name for name, kept in named if kept is None or kept.colors == self.world.bodies[name].colors]

    def instruct(self, instructions: Sequence[str]) -> None:
        """Set the instructions of this episode."""
        self.instructions = tuple(instructions)

    @property
    def cameras(self) -> Cameras:
        """The cameras by name; `cameras["front"].set_pose(...)` moves one."""
        return self.observer.cameras

    def kept(self, owner: object, make: Callable[[], KeptT]) -> KeptT:
        """Return the data that `owner`, such as an action mode, stores in this runtime; the first call creates it with `make`."""
        if owner not in self._kept:
            self._kept[owner] = make()
        kept: KeptT = self._kept[owner]
        return kept

    def register_step_callback(self, callback: TickFunction | None) -> None:
        """Call `callback` once after each control tick, in addition to the callbacks registered before.

        Args:
            callback: Function without arguments; None removes all callbacks.
        """
        if callback is None:
            for registered in tuple(self._callbacks):
                self.remove_step_callback(registered)
        elif callback not in self._callbacks:
            self._callbacks.append(callback)
            last = len(self.after_tick) - (self._result is not None)  # success is evaluated last
            self.after_tick.insert(last, callback)

    def remove_step_callback(self, callback: TickFunction) -> None:
        """Undo `register_step_callback`; do nothing if the callback is not registered."""
        if callback in self._callbacks:
            self._callbacks.remove(callback)
            self.after_tick.remove(callback)

    @contextmanager
    def calling(self, *, before: TickFunction | None = None, after: TickFunction | None = None) -> Iterator[None]:
        """In a block, call functions before and after each control tick, ahead of the other functions."""
        added = [(functions, new) for functions, new in ((self.before_tick, before), (self.after_tick, after)) if new is not None]
        for functions, new in added:
            functions.insert(0, new)
        try:
            yield
        finally:
            for functions, new in added:
                functions.remove(new)

    @contextmanager
    def ahead(self) -> Iterator[None]:
        """Simulate a block ahead of time: call no callbacks and listeners, and restore the state afterwards."""
        before, called = self.save(), (self.before_tick, self.after_tick, self.listeners)
        self.before_tick, self.after_tick, self.listeners = [], [self.task.step], Listeners()
        try:
            yield
        finally:
            self.before_tick, self.after_tick, self.listeners = called
            self.restore(before)

    def step(self) -> None:
        """Advance one control tick: the functions of `before_tick`, the physics, the functions of `after_tick`."""
        for function in tuple(self.before_tick):
            function()
        self.world.step()
        for function in tuple(self.after_tick):
            function()

    @property
    def over(self) -> bool:
        """Whether a tick of the present action has ended the episode, so that the rest of the action is skipped."""
        return self._result is not None and self._result.over

    @contextmanager
    def acting(self) -> Iterator[ActionResult]:
        """Evaluate success and end of the episode after each tick of a block (one action), and at least once."""
        before, result = self._result, ActionResult(self.task)
        self._result = result
        self.after_tick.append(result.evaluate)
        try:
            yield result
            if not result.evaluated:
                result.evaluate()
        finally:
            self._result = before
            self.after_tick.remove(result.evaluate)

    def refuse_opening(self, refused: RefusedOpening) -> None:
        """Record in the result of the present action why the fingers do not open."""
        if self._result is not None:
            self._result.refused_opening = refused

    def drive_to(self, target: FloatArray) -> None:
        """Move the arm towards joint positions `target` [rad] for one tick, then hold its position."""
        self.robot.set_position_targets(target)
        self.step()
        self.hold()

    def place_task(self, rng: np.random.Generator) -> None:
        """Put the task at a random pose on the table, drawn from `rng`; raise BoundaryError if there is none."""
        self.task.place(rng)

    def hold(self) -> None:
        """Hold the arm at its present position."""
        self.robot.set_position_targets(self.robot.joint_positions)

    def get_observation(self) -> Observation:
        """Return an observation without a simulation step."""
        with self.listeners.observe():
            return self.observer.observe(self.task, self.variation, self.noise_rng, self.instructions)

    @contextmanager
    def listening(self, listener: Listener) -> Iterator[None]:
        """Call `listener` for plans, control ticks, observations and segments, for the duration of a block."""
        began = 0.0

        def before() -> None:
            nonlocal began
            began = time.process_time()

        def after() -> None:
            listener.on_tick(time.process_time() - began)

        with (
            self.planner.listeners.including(listener),
            self.listeners.including(listener),
            self.calling(before=before, after=after),
        ):
            yield

    def refresh_planner(self) -> None:
        """Update the planner with a snapshot of the present world."""
        self.planner.update(self.world.snapshot())

    def touching(self) -> tuple[str, ...]:
        """Names of bodies that the arm touches and does not hold."""
        held = set(self.gripper.held)
        return tuple(name for name in self.robot.touching() if name not in held)

    def check_target_in_workspace(self, position: FloatArray) -> None:
        """Raise InvalidActionError if `position` (3,) [m] is not strictly inside the workspace box."""
        for axis, letter in enumerate("xyz"):
            low, high = TIP_WORKSPACE[:, axis]
            if not low < position[axis] < high:
                raise InvalidActionError(
                    f"The target has {letter} = {position[axis]:.4f} m, outside the workspace: "
                    f"{letter} must be between {low} and {high} m. Choose a target inside.",
                    "outside the workspace",
                )

    def save(self, *, portable: bool = False) -> RuntimeState:
        """Return the present state; only a `portable` one can be pickled."""
        world, task, noise = self.world.save(portable), self.task.state(), self.noise_rng.bit_generator.state
        return RuntimeState(world, task, self.variation, self.instructions, noise, self._planning_seed, self.build)

    def restore(self, state: RuntimeState) -> None:
        """Restore `state` exactly."""
        self.world.restore(state.world)
        self.task.set_state(state.task)
        self.variation, self.instructions = state.variation, state.instructions
        self.noise_rng.bit_generator.state = state.noise
        self._planning_seed = state.planning


class EmptyTable(Task):
    """No task: the arm alone at an empty table."""

    def init_task(self) -> None:
        """Do nothing."""


def build_runtime(
    task: type[Task],
    model: RobotModel,
    config: ObservationConfig,
    *,
    planning: PlannerConfig | None = None,
    attach_grasped_objects: bool = True,
    renderer: RendererName = "cpu",
    camera_places: dict[str, FloatArray] | None = None,
    kind: type[RuntimeT] = Runtime,  # type: ignore[assignment]
) -> RuntimeT:
    """Build the world of a task and set the task up.

    Args:
        task: Class of the task; `EmptyTable` has no scene file.
        model: Model of the arm.
        config: Contents of observations.
        planning: Settings of the planner.
        attach_grasped_objects: As in `Runtime`.
        renderer: Renderer of images.
        camera_places: Poses (7,) of moved cameras, by name; shared with other runtimes.
        kind: `Runtime`, or a subclass of it.
    """
    spec = SceneSpec(format=1) if task is EmptyTable else task_scene(task)
    world, running = _with_task(task, World(spec, model.description, renderer=renderer))
    try:
        planner = MotionPlanner(model, planning)
        return kind(world, running, model.description, model, planner, config, attach_grasped_objects, camera_places)
    except BaseException:
        world.close()
        raise


def _with_task(kind: type[Task], world: World) -> tuple[World, Task]:
    """Return a world, and the task in it; if the task cannot be set up, the world is closed."""
    try:
        task = kind(world)
        task.init_task()
    except BaseException:
        world.close()
        raise
    return world, task


MIN_SPEED = 0.13
"""Joint speed in the first and last tick of a motion [rad/s]. The rule of key frames treats speeds below 0.1 as rest."""
REST_SPEED = 0.05
"""Joint speed below which the arm is at rest [rad/s]."""
_REST_TICKS = 10
"""Maximum number of control ticks until the arm is at rest after a motion."""
_GRIPPER_TICKS = 60
"""Maximum number of control ticks of a finger motion."""
_SETTLE_TICKS_AFTER_OPENING = 10
"""Number of control ticks for a released object to settle."""
_STABLE_SECONDS = 1.0
"""Time after which success must still hold to be stable [s]."""


def follow(
    runtime: Runtime,
    trajectory: Trajectory,
    *,
    on_tick: Callable[[FloatArray], None] = lambda target: None,
    whole: bool = False,
    compliant: bool = False,
    ticks: int | None = None,
) -> None:
    """Track `trajectory` until the arm is at rest at its end, or until the episode is over.

    Args:
        runtime: Runtime of the arm.
        trajectory: Timed joint motion that starts at the present configuration.
        on_tick: Function that is called after each tick with the commanded joint positions (n,) [rad].
        whole: Continue when the episode is over.
        compliant: Move slowly, and yield to contact, as `CompliantFollowing` does.
        ticks: Return after this number of ticks, while the arm moves.
    """
    target = runtime.robot.joint_positions
    dt = runtime.world.control_dt
    targets = _compliant_targets(runtime, trajectory) if compliant else TrajectoryTracker(trajectory, dt, MIN_SPEED)
    for target in islice(targets, ticks):
        lost = True
        while lost:
            runtime.drive_to(target)
            on_tick(target)
            if runtime.over and not whole:
                return
            lost = runtime.world.command_lost
    if ticks is not None:
        return
    for _ in range(_REST_TICKS):
        if (runtime.over and not whole) or np.abs(runtime.robot.joint_velocities).max() < REST_SPEED:
            return
        runtime.drive_to(target)
        on_tick(target)


def _compliant_targets(runtime: Runtime, trajectory: Trajectory) -> Iterator[FloatArray]:
    """Yield the commands (n,) of a compliant approach [rad], each from the measured state of its tick."""
    following, robot = CompliantFollowing(runtime.model, trajectory, runtime.world.control_dt), runtime.robot
    while not following.done:
        yield following.command(robot.joint_positions, robot.joint_torques)


def move_gripper(
    runtime: Runtime,
    amount: float,
    *,
    release: bool,
    speed: float,
    attach: bool = True,
    detach_before_open: bool = True,
    on_tick: Callable[[], None] = lambda: None,
) -> None:
    """Move the fingers to an opening fraction, and attach or release bodies. Stop early if the episode ends.

    The fingers close in the physics simulation until they stall. Then each registered graspable body that both fingers touch
    is fixed to the gripper.

    Args:
        runtime: Runtime of the gripper.
        amount: Opening fraction, from 0 (closed) to 1 (open).
        release: Release held bodies (an opening motion); otherwise attach the bodies between the fingers afterwards.
        speed: Finger speed [m/s].
        attach: Fix bodies to the gripper; otherwise friction alone holds them.
        detach_before_open: Release bodies before the fingers move; otherwise afterwards.
        on_tick: Function that is called after each tick.
    """
    if runtime.robot.mode == "torque":
        runtime.hold()
    if release and detach_before_open:
        runtime.gripper.release()
    runtime.gripper.set_target(amount, speed)
    for tick in range(_GRIPPER_TICKS):
        runtime.step()
        on_tick()
        if runtime.over or (tick > 0 and not runtime.gripper.moving):
            break
    hold_or_release(runtime, release=release, attach=attach)
    for _ in range(_SETTLE_TICKS_AFTER_OPENING if release else 0):
        if runtime.over:
            return
        runtime.step()
        on_tick()


def hold_or_release(runtime: Runtime, *, release: bool, attach: bool) -> None:
    """Release all bodies, or fix each graspable body that both fingers touch to the gripper."""
    if release:
        runtime.gripper.release()
    elif attach:
        for name in runtime.gripper.between_fingers():
            runtime.gripper.grasp(name)


def success_is_stable(runtime: Runtime) -> bool:
    """Return whether success holds now and still holds after 1 s with arm and gripper stationary.

    The state is restored afterwards (measured torques from the next tick on); observers and callbacks are not called.
    """
    with runtime.ahead():
        reached = bool(runtime.task.success()[0])
        if reached:
            runtime.hold()
            runtime.gripper.hold()
            for _ in range(round(_STABLE_SECONDS / runtime.world.control_dt)):
                runtime.step()
            reached = bool(runtime.task.success()[0])
    return reached
