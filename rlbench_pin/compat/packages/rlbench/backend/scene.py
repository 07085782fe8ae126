"""The scene: world, task and robot, with the API of RLBench."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from pyrep.const import ObjectType
from pyrep.objects import Dummy, Shape, VisionSensor
from pyrep.pyrep import PyRep
from rlbench.backend.robot import Robot
from rlbench.backend.spawn_boundary import Workspace
from rlbench.backend.task import Task
from rlbench.observation_config import ObservationConfig
from rlbench_pin.compat.objects.elements import CAMERA_NAMES, MASK_SUFFIX
from rlbench_pin.compat.simulator import SceneRuntime, Simulator
from rlbench_pin.environment import demos
from rlbench_pin.environment.episode import EpisodeOrigin, EpisodeRandom
from rlbench_pin.environment.reset import SETTLE_TICKS, start_episode
from rlbench_pin.environment.runtime import TIP_WORKSPACE, EmptyTable
from rlbench_pin.errors import (
    BoundaryError,
    DemoError,
    NotReset,
    NoWaypointsError,
    ResetError,
    TaskEnvironmentError,
    WaypointError,
)
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.tasks import Task as NativeTask

STEPS_BEFORE_EPISODE_START = SETTLE_TICKS
"""Number of control ticks in which the objects of a placed task settle."""

SEEDS = 2**31
"""Upper bound of random seeds."""
_WORD = 32  # [bit]


class EpisodeSeeds:
    """Draws seeds, and recognizes the seeds of demonstrations.

    Programs call `demo.restore_state()`, which seeds the global generator, then reset, and expect the start of the demonstration.
    So if the global generator was just seeded with the seed of a known demonstration, `draw` returns the seed of that episode.
    """

    def __init__(self) -> None:
        self._known: dict[bytes, tuple[int, int]] = {}

    def remember(self, demo: Demo) -> None:
        """Store the seed of a demonstration; a demonstration without a seed is ignored."""
        seed = demo.random_seed
        if isinstance(seed, int | np.integer) and seed >= 0:
            words = np.array([int(seed) >> shift & 0xFFFFFFFF for shift in range(0, max(int(seed).bit_length(), 1), _WORD)])
            fresh = np.random.RandomState(int(seed) if len(words) == 1 else words)
            self._known[_fingerprint(fresh.get_state())] = int(seed), demo.attempt

    def draw(self) -> tuple[int, int]:
        """Return the seed of an episode and the number of the attempt."""
        known = self._known.get(_fingerprint(np.random.get_state())) if self._known else None
        seed = int(np.random.randint(SEEDS))
        return (seed, 0) if known is None else known


def _fingerprint(state: Any) -> bytes:
    """Return a fingerprint of the state of a generator."""
    keys, position = state[1], int(state[2])
    return position.to_bytes(2, "big") + np.asarray(keys).tobytes()


class Scene:
    """World, task and robot.

    The package steps and observes through `step`, `get_observation` and `check_target_in_workspace` of this
    object, so that a subclass can override them.

    Args:
        pyrep: The simulator.
        robot: Arm and gripper.
        obs_config: Contents of observations; a new default when None.
        robot_setup: Name of the arm.

    Attributes:
        pyrep: The simulator.
        robot: Arm and gripper.
        robot_setup: Name of the arm.
        task: The loaded task, or None.
    """

    def __init__(
        self, pyrep: PyRep, robot: Robot, obs_config: ObservationConfig | None = None, robot_setup: str = "panda"
    ) -> None:
        self._step_callback: Callable[[], None] | None = None
        low, high = TIP_WORKSPACE.tolist()
        self._workspace_minx, self._workspace_miny, self._workspace_minz = low
        self._workspace_maxx, self._workspace_maxy, self._workspace_maxz = high
        self.pyrep, self.robot, self.robot_setup = pyrep, robot, robot_setup
        self.task: Any = None
        self._obs_config = ObservationConfig() if obs_config is None else obs_config
        self._observed: dict[str, Any] | None = None
        self._frame: Observation | None = None
        self._next_demo: Demo | None = None
        self._seeds = EpisodeSeeds()
        self._forget_task()
        self._runtime = self._build(EmptyTable)
        self._start_arm_joint_pos = self._runtime.robot.joint_positions.tolist()
        self._starting_gripper_joint_pos = self._runtime.robot.fingers.tolist()
        self._initial_robot_state = (robot.arm.get_configuration_tree(), robot.gripper.get_configuration_tree())
        for name in CAMERA_NAMES:  # programs read these private attributes
            setattr(self, f"_{name}", VisionSensor(name))
            setattr(self, f"_{name}{MASK_SUFFIX}", VisionSensor(name + MASK_SUFFIX))
        self._set_camera_properties()

    def _forget_task(self) -> None:
        """Set the attributes that depend on the task to their initial values."""
        self._has_init_task = self._has_init_episode = False
        self._variation_index = self._attempts = 0
        self._initial_task_state: Any = None
        self._initial_task_pose: Any = None
        self._joint_position_action: np.ndarray | None = None
        self._origin: EpisodeOrigin | None = None

    def _build(self, native: type[NativeTask]) -> SceneRuntime:
        """Build the world of a task and return its runtime, connected to this scene."""
        runtime = Simulator.current().load(native, self._obs_config, kind=SceneRuntime)
        runtime.serve(self)
        runtime.after_tick.append(self._after_step)
        return runtime

    def _set_camera_properties(self) -> None:
        """Check the settings of the cameras, which apply to each observation."""
        self._obs_config.check()

    @property
    def runtime(self) -> SceneRuntime:
        """World, task and planner of rlbench_pin."""
        return self._runtime

    # Workspace and callbacks ----------------------------------------------------------------------------------------

    def prepare(self) -> None:
        """Move the arm to `_start_arm_joint_pos`, if the arm has other joint positions."""
        if not np.array_equal(self._start_arm_joint_pos, self.robot.arm.get_joint_positions()):
            self.robot.arm.set_joint_positions(self._start_arm_joint_pos, disable_dynamics=True)

    def check_target_in_workspace(self, pos: Sequence[float] | np.ndarray) -> bool:
        """Whether a target (3,) [m] is strictly inside the workspace."""
        x, y, z = (float(value) for value in pos)
        return bool(
            self._workspace_minx < x < self._workspace_maxx
            and self._workspace_miny < y < self._workspace_maxy
            and self._workspace_minz < z < self._workspace_maxz
        )

    def register_step_callback(self, func: Callable[[], None] | None) -> None:
        """Call `func` after each control tick; it replaces the previous function, and None removes it."""
        self._step_callback = func

    def _after_step(self) -> None:
        if self._step_callback is not None:
            self._step_callback()

    @cached_property
    def _workspace(self) -> Shape:
        return Shape("workspace")

    @cached_property
    def _workspace_boundary(self) -> Workspace:
        return Workspace(self._workspace)

    @cached_property
    def target_workspace_check(self) -> Dummy:
        """Dummy that programs move to targets."""
        return Dummy.create()

    @cached_property
    def _robot_shapes(self) -> list[Any]:
        return list(self.robot.arm.get_objects_in_tree(object_type=ObjectType.SHAPE))

    # Tasks ----------------------------------------------------------------------------------------------------------

    def load(self, task: Task) -> None:
        """Build the world of a task, replace the current world by it, and connect the task to it."""
        self._forget_task()
        self._runtime = self._build(type(task).native_class())
        self.task = task
        task.bind(self._runtime.task)
        self._runtime.world.end_building()
        self._initial_task_pose = task.boundary_root().get_orientation()

    def unload(self) -> None:
        """Replace the world of the task by the empty table; without a task there is no effect."""
        if self.task is None:
            return
        self._runtime.task.end_episode()
        self._forget_task()
        self.task = None
        self._runtime = self._build(EmptyTable)

    def init_task(self) -> None:
        """Save the initial state of the task; `load` has called `init_task` of the task."""
        self._initial_task_state = self._loaded("init_task").get_state()
        self._has_init_task = True

    def init_episode(self, index: int, randomly_place: bool = True, max_attempts: int = 5, place_demo: bool = False) -> list[str]:
        """Set up one episode, with random values from numpy's global generator.

        Args:
            index: Variation of the task.
            randomly_place: Place the task at a random pose.
            max_attempts: Maximum number of placements.
            place_demo: No effect: the episode always starts as the demonstration of `start_next_as`, if there is one.

        Returns:
            The instructions.

        Raises:
            BoundaryError: There was no free pose for an object.
            WaypointError: The last placement had unreachable waypoints.
        """
        self._loaded("init_episode")
        if not self._has_init_task:
            self.init_task()
        demo, self._next_demo = self._next_demo, None
        seed, attempt = self._seeds.draw()
        if demo is not None:
            seed, attempt = demos.check_start(demo, self.task.get_name(), self._runtime.model.description.reference), demo.attempt
        random = EpisodeRandom.from_seed(seed, attempt)
        self._variation_index = index
        self._before_episode()
        self._runtime.build_again()
        try:
            start = start_episode(self._runtime, index, random, static=not randomly_place, max_attempts=max_attempts)
        except ResetError as error:
            kind = WaypointError if error.causes[-1:] and not error.causes[-1].startswith("BoundaryError") else BoundaryError
            raise kind(str(error)) from error
        if demo is not None:
            demos.restore_start(self._runtime, demo)
        self._attempts = start.attempts
        self._origin = EpisodeOrigin(seed, attempt, start.attempts, start.instructions)
        self._has_init_episode = True
        self._after_episode_start(index, random.randomization)
        return list(start.instructions)

    def start_next_as(self, demo: Demo | None) -> None:
        """Start the next `init_episode` as a demonstration; None starts it at random."""
        if demo is not None:
            demos.check_start(demo, self._loaded("start_next_as").get_name(), self._runtime.model.description.reference)
        self._next_demo = demo

    def remember_start(self, demo: Demo) -> None:
        """Start an episode as `demo` if numpy's global generator was just seeded with the seed of the demonstration."""
        self._seeds.remember(demo)

    @property
    def descriptions(self) -> list[str]:
        """Instructions of the current episode.

        Raises:
            NotReset: There is no episode (also a RuntimeError).
        """
        if self._origin is None:
            raise NotReset("get_task_descriptions")
        return list(self._origin.instructions)

    def sign(self, demo: Demo) -> None:
        """Add seed, instructions, task and variation of the episode to a demonstration that a program made of observations."""
        if self._origin is not None and demo.random_seed is None:
            origin = self._origin
            demo.random_seed, demo.attempt, demo.num_reset_attempts = origin.seed, origin.attempt, origin.reset_attempts
            demo.instructions, demo.task_name = origin.instructions, self.task.get_name()
            demo.variation_number = self._variation_index
            self.remember_start(demo)

    def _before_episode(self) -> None:
        """Called before the setup of an episode."""

    def _after_episode_start(self, variation: int, rng: np.random.Generator) -> None:
        """Called after the setup of an episode, when the objects have settled."""

    def reset(self) -> None:
        """End the episode and restore the initial state of the world."""
        self._runtime.task.end_episode()
        world = self._runtime.world
        world.restore(world.origin)
        self._has_init_episode = False

    def _place_task(self) -> None:
        """Place the task at a random pose on the table. Each placement of an episode calls this, unless the task is static."""
        root, world = self.task.boundary_root(), self._runtime.world
        if root == self.task.get_base() and not np.array_equal(world.root.pose, world.spec.placement.pose):
            world.place_root(world.spec.placement.pose)
        low, high = self.task.base_rotation_bounds()
        self._workspace_boundary.clear()
        self._workspace_boundary.sample(root, min_rotation=low, max_rotation=high)

    def place(self, rng: np.random.Generator) -> None:
        """Place the task at a random pose on the table, drawn from `rng`."""
        with self._workspace_boundary.drawing_from(rng):
            self._place_task()

    def _loaded(self, call: str) -> Any:
        """Return the loaded task, or raise TaskEnvironmentError with the name of the method."""
        if self.task is None:
            raise TaskEnvironmentError(f"`Scene.{call}` needs a task. Call `load(task)` first, or `Environment.get_task(...)`.")
        return self.task

    # The loop -------------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Advance one control tick: physics, the step of the task, then the registered function."""
        self._runtime.advance()

    def get_observation(self) -> Observation:
        """Return an observation without a simulation step."""
        observation = self._runtime.observe()
        self._observed = observation.misc
        try:
            observation.misc = self._get_misc()
        finally:
            self._observed = None
        return observation

    def _get_misc(self) -> dict[str, Any]:
        """Return the `misc` entries of the observation in progress, or of a new observation."""
        misc = dict(self._runtime.observe().misc if self._observed is None else self._observed)
        if self._frame is not None and self._joint_position_action is not None:
            misc["joint_position_action"] = self._joint_position_action
        return misc

    def get_observation_config(self) -> ObservationConfig:
        """Return the observation config."""
        return self._obs_config

    # Demonstrations -------------------------------------------------------------------------------------------------

    def get_demo(
        self,
        record: bool = True,
        callable_each_step: Callable[[Observation], None] | None = None,
        randomly_place: bool = True,
    ) -> Demo:
        """Execute a demonstration in the current episode and return it; without an episode, start one first.

        Args:
            record: Store observations; otherwise the demonstration is empty.
            callable_each_step: Function that is called with each observation.
            randomly_place: Place the task at a random pose, if an episode is started.

        Raises:
            NoWaypointsError: The task has no waypoints.
            DemoError: The demonstration had no success, or a motion could not be planned.
        """
        task = self._loaded("get_demo")
        if not self._has_init_episode:
            self.init_episode(self._variation_index, randomly_place=randomly_place)
        if self._origin is None:
            raise NotReset("get_demo")
        if not self._runtime.task.get_waypoints():
            raise NoWaypointsError(f"Task '{task.get_name()}' has no waypoints, so no demonstration can be planned.", task)
        frames: list[Observation] = []
        player = demos.DemoPlayer(
            self._runtime,
            record=record or callable_each_step is not None,
            record_gripper=self._obs_config.record_gripper_closing,
            on_frame=lambda frame: self._keep_frame(frame, frames, record, callable_each_step),
        )
        outcome = demos.play_demo(self._origin, player)
        if outcome.demo is None:
            raise DemoError(f"Task '{task.get_name()}' has no successful demonstration: {outcome.cause}", task)
        self.remember_start(outcome.demo)
        return outcome.demo.with_observations(frames)

    def _keep_frame(
        self, frame: Observation, frames: list[Observation], record: bool, func: Callable[[Observation], None] | None
    ) -> None:
        """Call `_demo_record_step` for a new observation."""
        self._joint_position_action, self._frame = frame.misc.get("joint_position_action"), frame
        try:
            self._demo_record_step(frames, record, func)
        finally:
            self._frame = None

    def _demo_record_step(self, demo_list: list[Observation], record: bool, func: Callable[[Observation], None] | None) -> None:
        """Record the current observation: append it to the list with `record`, and call `func` with it."""
        if not record and func is None:
            return
        observation = self.get_observation() if self._frame is None else self._frame
        if record:
            demo_list.append(observation)
        if func is not None:
            func(observation)
