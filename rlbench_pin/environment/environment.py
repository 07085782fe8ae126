"""`Environment`: select the actions and observations, and load tasks."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from rlbench_pin.datasets.manifest import has_manifest
from rlbench_pin.environment.actions.modes import ActionMode, attaches_grasped
from rlbench_pin.environment.factors import FactorSetting, FactorsLike
from rlbench_pin.environment.observations.config import ObservationConfig
from rlbench_pin.environment.observations.observe import Camera, Cameras, camera_misc
from rlbench_pin.environment.randomization.config import (
    DynamicsRandomizationConfig,
    RandomizeEvery,
    VisualRandomizationConfig,
    check_randomization,
)
from rlbench_pin.environment.randomization.randomizer import Randomizer
from rlbench_pin.environment.runtime import EmptyTable, Runtime, build_runtime
from rlbench_pin.environment.stored import StoredSelection, read_stored_demos, read_stored_descriptions
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DatasetError, EnvironmentClosed, InvalidArgument, NoShapedReward, TaskEnvironmentError
from rlbench_pin.observation import CAMERAS, Demo
from rlbench_pin.planning.planner import PlannerConfig
from rlbench_pin.robot.description import DEFAULT_ROBOT, robot_description
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.spec import SceneSpec
from rlbench_pin.sim import RENDERERS, RendererName, World, give_back_memory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Task, find_task
from rlbench_pin.values import as_choice, as_flag, as_number, as_path, as_record, as_seed, names_arguments

_SCENE_DATA = {"intrinsics": "intrinsics", "extrinsics": "extrinsics", "near_plane": "near", "far_plane": "far"}
"""Name in the data of a scene -> name in `misc`."""


class Environment:
    """A simulated robot at a table; `get_task` loads a task.

    Args:
        action_mode: Meaning, size and bounds of an action.
        dataset_root: Folder of stored demonstrations; the default "" means none.
        obs_config: Contents of observations; None takes a new default configuration.
        headless: Accepted for compatibility with RLBench, without effect: no window is ever opened.
        static_positions: Keep each task at the pose that its scene file gives, instead of a random pose.
        robot_setup: Name of the arm (case is ignored), or path of its TOML file.
        randomize_every: Event that starts a new randomization; needs visual or dynamics settings. None never randomizes.
        frequency: Randomize at the first event and at every `frequency`-th event after it.
        visual_randomization_config: Settings of visual randomization.
        dynamics_randomization_config: Settings of dynamics randomization.
        attach_grasped_objects: Fix grasped bodies to the gripper. A setting of the gripper mode takes precedence.
        shaped_rewards: Return the shaped reward of the task, instead of 1 for success and 0 otherwise.
        arm_max_velocity: Largest norm of the joint velocity in planned motions [rad/s].
        arm_max_acceleration: Largest rate of change of that norm, and largest acceleration of each joint [rad/s^2].
        seed: Seed for all calls that are not given a seed; None draws one.
        renderer: Renderer of images: `cpu`, `egl`, or `auto` (EGL if available, else CPU). CPU and EGL images differ slightly.
        factors: Factors of generalisation, such as `light_color:2+friction:1`; `rlbench-pin factors` lists them.

    Raises:
        DatasetError: `dataset_root` does not exist (also a RuntimeError).
        InvalidArgument: An argument has an invalid value or type (also a ValueError).
        UnknownRobot: There is no arm with this name (also a ValueError).
    """

    @names_arguments
    def __init__(
        self,
        action_mode: ActionMode,
        dataset_root: str = "",
        obs_config: ObservationConfig | None = None,
        headless: bool = False,
        static_positions: bool = False,
        robot_setup: str = DEFAULT_ROBOT,
        randomize_every: RandomizeEvery | None = None,
        frequency: int = 1,
        visual_randomization_config: VisualRandomizationConfig | None = None,
        dynamics_randomization_config: DynamicsRandomizationConfig | None = None,
        attach_grasped_objects: bool = True,
        shaped_rewards: bool = False,
        arm_max_velocity: float = 1.0,
        arm_max_acceleration: float = 4.0,
        *,
        seed: int | None = None,
        renderer: RendererName = "cpu",
        factors: FactorsLike = "",
    ) -> None:
        _check_given(action_mode, dataset_root)
        check_randomization(randomize_every, frequency, visual_randomization_config, dynamics_randomization_config)
        self._action_mode, self._dataset_root = action_mode, str(dataset_root)
        self._obs_config = _checked_settings(obs_config)
        self._factors = FactorSetting.of(factors)
        self._randomize_every, self._frequency = randomize_every, frequency
        self._visual, self._dynamics = visual_randomization_config, dynamics_randomization_config
        self._renderer: RendererName = as_choice(renderer, "renderer", RENDERERS)  # type: ignore[assignment]
        _check_switches(headless=headless, static_positions=static_positions, shaped_rewards=shaped_rewards)
        self._static_positions, self._shaped_rewards = static_positions, shaped_rewards
        self._robot = robot_description(robot_setup)
        self._attach_grasped_objects = as_flag(attach_grasped_objects, "attach_grasped_objects", InvalidArgument)
        self._planner_config = PlannerConfig(
            max_velocity=as_number(arm_max_velocity, "arm_max_velocity", InvalidArgument, above=0.0),
            max_acceleration=as_number(arm_max_acceleration, "arm_max_acceleration", InvalidArgument, above=0.0),
        )
        self._seeds = np.random.default_rng(None if seed is None else as_seed(seed, "seed", InvalidArgument))
        self._places: dict[str, FloatArray] = {}
        self._model: RobotModel | None = None
        self._runtime: Runtime | None = None

    # Life -------------------------------------------------------------------------------------------------------

    def launch(self) -> None:
        """Load the robot.

        Raises:
            TaskEnvironmentError: The environment is already launched (also a RuntimeError).
        """
        if self._model is not None:
            raise AlreadyLaunched("The environment is already launched. Call `shutdown()` before another `launch()`.")
        self._model = RobotModel(self._robot)

    def shutdown(self) -> None:
        """Close the simulation and free its memory. Further calls have no effect."""
        runtime, self._runtime, self._model = self._runtime, None, None
        if runtime is not None:
            runtime.world.close()
            del runtime
            give_back_memory()

    def __enter__(self) -> Environment:
        if self._model is None:
            self.launch()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.shutdown()

    # Tasks ------------------------------------------------------------------------------------------------------

    def get_task(self, task: type[Task] | str | PathLike[str]) -> TaskEnvironment:
        """Unload the previous task, load a task by class, name or file, and return its environment.

        Args:
            task: A class, a name from `rlbench-pin list`, or the path of a task file outside the package, such as `mine/x.py`.

        Raises:
            UnknownName: There is no task with this name; the message proposes the most similar one.
            TaskError: The file does not exist, cannot be executed, or contains no task class with the name of the file.
            NoShapedReward: Shaped rewards are on and the task has none (also a RuntimeError).
        """
        chosen = find_task(task) if isinstance(task, str | PathLike) else task
        if not isinstance(chosen, type) or not issubclass(chosen, Task):
            raise InvalidArgument(
                "task", task, "has to be the name, the file or the class of a task", "`rlbench-pin list` prints the names."
            )
        if self._shaped_rewards and chosen.reward is Task.reward:
            raise NoShapedReward(chosen.get_name())
        if self._model is None:
            self.launch()
        assert self._model is not None
        runtime = self._build(chosen, self._model)
        if self._runtime is not None:
            self._runtime.world.close()
        self._runtime = runtime
        environment = TaskEnvironment(
            runtime,
            self._action_mode,
            self._obs_config,
            self._seeds,
            self._dataset_root,
            self._static_positions,
            self._shaped_rewards,
            self._randomizer(runtime),
        )
        environment.set_factors(self._factors)
        return environment

    def _randomizer(self, runtime: Runtime) -> Randomizer | None:
        if self._randomize_every is None:
            return None
        return Randomizer(runtime, self._obs_config, self._randomize_every, self._frequency, self._visual, self._dynamics)

    def _build(self, task: type[Task], model: RobotModel) -> Runtime:
        return build_runtime(
            task,
            model,
            self._obs_config,
            planning=self._planner_config,
            attach_grasped_objects=attaches_grasped(self._action_mode, self._attach_grasped_objects),
            renderer=self._renderer,
            camera_places=self._places,
        )

    @names_arguments
    def get_demos(
        self,
        task_name: str,
        amount: int,
        variation_number: int = 0,
        image_paths: bool = False,
        random_selection: bool = True,
        from_episode_number: int = 0,
    ) -> list[Demo]:
        """Return stored demonstrations without starting a simulator.

        Raises:
            DatasetError: There is no dataset root, or it does not contain these demonstrations.
            UnknownName: There is no task with this name.
        """
        wanted = StoredSelection(amount, variation_number, image_paths, random_selection, from_episode_number)
        return read_stored_demos(self._dataset_root, self._stored_name(task_name), wanted, self._obs_config, self._seeds)

    def get_task_descriptions_with_episode(self, task_name: str, episode_number: int) -> list[str]:
        """Return the instructions of a stored episode; its index counts through all variations.

        Raises:
            DatasetError: There is no dataset root, or no such episode.
            UnknownName: There is no task with this name.
        """
        return read_stored_descriptions(self._dataset_root, self._stored_name(task_name), episode_number)

    def _stored_name(self, task: str) -> str:
        """Return the name under which demonstrations of a task are stored, without running code of a dataset."""
        task = as_record(task, str, "task_name", InvalidArgument)
        is_stored = self._dataset_root and task.isidentifier() and has_manifest(Path(self._dataset_root), task)
        return task if is_stored else find_task(task).get_name()

    # What it offers ---------------------------------------------------------------------------------------------

    @property
    def action_shape(self) -> tuple[int]:
        """Shape of an action; available after `launch()`."""
        return (self.action_size,)

    @property
    def action_size(self) -> int:
        """Number of values of an action; available after `launch()`."""
        return self._action_mode.shape(self._launched("The shape of actions is"))[0]

    def action_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest values of an action, each of shape (n,); available after `launch()`.

        Raises:
            NotLaunched: Before `launch()` (also a RuntimeError).
        """
        return self._action_mode.bounds(self._launched("The bounds of actions are"))

    def _launched(self, what: str) -> Runtime:
        """Return the present runtime; before the first task, its world is the arm at an empty table."""
        if self._model is None:
            raise NotLaunched(f"{what} unknown before the robot is loaded. Call `launch()` or `get_task(...)` first.")
        if self._runtime is None:
            self._runtime = self._build(EmptyTable, self._model)
        return self._runtime

    @property
    def cameras(self) -> Cameras:
        """The cameras by name; available after `launch()`. A pose from `set_pose` applies to all tasks of this environment."""
        return self._launched("The cameras are").cameras

    def get_scene_data(self) -> dict[str, dict[str, Any] | None]:
        """Return intrinsics, extrinsics and clipping planes of each camera at the home posture; None for a disabled camera."""
        with World(SceneSpec(format=1), self._robot) as world:
            cameras = Cameras(world, self._robot, self._obs_config, self._places)
            return {f"{name}_camera": _camera_data(cameras[name]) for name in CAMERAS}


def _check_given(mode: object, root: object) -> None:
    if not isinstance(mode, ActionMode):
        hint = "For example `MoveArmThenGripper(JointVelocity(), Discrete())`."
        raise InvalidArgument("action_mode", mode, "has to be an ActionMode", hint)
    if not isinstance(root, str | Path):
        raise InvalidArgument("dataset_root", root, "has to be the path of a folder, or ''")
    if root and not as_path(root, "dataset_root", InvalidArgument).is_dir():
        raise DatasetError(f"The dataset root '{root}' does not exist. Create it, or pass dataset_root=''.")


def _check_switches(**switches: object) -> None:
    for name, switch in switches.items():
        as_flag(switch, name, InvalidArgument)


def _checked_settings(config: ObservationConfig | None) -> ObservationConfig:
    if config is not None and not isinstance(config, ObservationConfig):
        raise InvalidArgument("obs_config", config, "has to be an ObservationConfig, or None for the default settings")
    chosen = ObservationConfig() if config is None else config
    chosen.check()
    return chosen


def _camera_data(camera: Camera) -> dict[str, Any] | None:
    if not camera.config.is_used:
        return None
    misc = camera_misc(camera.name, camera.view())
    return {what: misc[f"{camera.name}_camera_{key}"] for what, key in _SCENE_DATA.items()}


class AlreadyLaunched(TaskEnvironmentError, RuntimeError):
    """`launch` was called on a launched environment."""


class NotLaunched(EnvironmentClosed):
    """A property of an environment was read before `launch`."""
