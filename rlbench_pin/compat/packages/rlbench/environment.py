"""`Environment`: select the actions and observations, and load tasks."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any

from pyrep.pyrep import PyRep
from rlbench.action_modes.action_mode import ActionMode
from rlbench.backend.const import *  # noqa: F403
from rlbench.backend.const import TTT_FILE
from rlbench.backend.robot import Robot
from rlbench.backend.scene import Scene
from rlbench.backend.task import Task
from rlbench.const import MODELS, SUPPORTED_ROBOTS
from rlbench.observation_config import ObservationConfig
from rlbench.sim2real import (
    DomainRandomizationScene,
    DynamicsRandomizationConfig,
    RandomizeEvery,
    VisualRandomizationConfig,
)
from rlbench.task_environment import TaskEnvironment
from rlbench.utils import InvalidTaskName, get_stored_demos, name_to_task_class
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.actions import JointPositionActionMode
from rlbench_pin.environment.environment import AlreadyLaunched, NotLaunched
from rlbench_pin.environment.environment import Environment as NativeEnvironment
from rlbench_pin.environment.randomization.config import check_randomization
from rlbench_pin.environment.stored import read_stored_descriptions
from rlbench_pin.errors import DatasetError, TaskEnvironmentError
from rlbench_pin.observation import Demo
from rlbench_pin.planning.planner import PlannerConfig
from rlbench_pin.robot.description import UnknownRobot

DIR_PATH = str(Path(__file__).parent)
"""Folder of this package."""


class Environment:
    """A simulated robot at a table; `get_task` loads a task.

    Args:
        action_mode: The action mode.
        dataset_root: Folder of stored demonstrations.
        obs_config: Contents of observations; a new default when None.
        headless: Has no effect: no window is ever opened.
        static_positions: Keep tasks at the poses of their scene files, instead of random poses.
        robot_setup: Name of the arm; case is ignored.
        randomize_every: Event that starts a new randomization; needs a randomization config.
        frequency: Randomize at every n-th event.
        visual_randomization_config: Visual randomization.
        dynamics_randomization_config: Dynamics randomization.
        attach_grasped_objects: Fix grasped bodies to the gripper. A setting of the gripper mode takes precedence.
        shaped_rewards: Return the shaped rewards of tasks.
        arm_max_velocity: Largest joint velocity in planned motions [rad/s].
        arm_max_acceleration: Largest joint acceleration in planned motions [rad/s^2].

    Raises:
        DatasetError: `dataset_root` does not exist (also a RuntimeError).
        UnknownRobot: There is no such arm (also a ValueError).
        RandomizationMisused: The arguments of randomization are invalid or contradict each other (also a ValueError).
    """

    def __init__(
        self,
        action_mode: ActionMode,
        dataset_root: str = "",
        obs_config: ObservationConfig | None = None,
        headless: bool = False,
        static_positions: bool = False,
        robot_setup: str = "panda",
        randomize_every: RandomizeEvery | None = None,
        frequency: int = 1,
        visual_randomization_config: VisualRandomizationConfig | None = None,
        dynamics_randomization_config: DynamicsRandomizationConfig | None = None,
        attach_grasped_objects: bool = True,
        shaped_rewards: bool = False,
        arm_max_velocity: float = 1.0,
        arm_max_acceleration: float = 4.0,
    ) -> None:
        self._action_mode, self._dataset_root = action_mode, str(dataset_root)
        self._obs_config = ObservationConfig() if obs_config is None else obs_config
        self._headless, self._static_positions = headless, static_positions
        self._robot_setup = robot_setup.lower()
        if self._robot_setup not in MODELS:
            raise UnknownRobot("robot", robot_setup, tuple(MODELS))
        check_randomization(randomize_every, frequency, visual_randomization_config, dynamics_randomization_config)
        self._randomize_every, self._frequency = randomize_every, frequency
        self._visual_randomization_config = visual_randomization_config
        self._dynamics_randomization_config = dynamics_randomization_config
        self._attach_grasped_objects, self._shaped_rewards = attach_grasped_objects, shaped_rewards
        self._arm_max_velocity, self._arm_max_acceleration = arm_max_velocity, arm_max_acceleration
        self._pyrep: PyRep | None = None
        self._robot: Robot | None = None
        self._scene: Scene | None = None
        self._prev_task: Task | None = None
        if self._dataset_root:
            self._check_dataset_structure()

    def _check_dataset_structure(self) -> None:
        """Raise DatasetError unless the dataset root is a folder."""
        if not Path(self._dataset_root).is_dir():
            raise DatasetError(f"The dataset root '{self._dataset_root}' does not exist. Create it, or pass dataset_root=''.")

    def _string_to_task(self, task_name: str) -> type[Task]:
        """Return the class of a task for its name in snake case."""
        try:
            return name_to_task_class(task_name)
        except InvalidTaskName as error:
            raise UnknownTaskName(str(error)) from error

    # Life -----------------------------------------------------------------------------------------------------------

    def launch(self) -> None:
        """Start the simulator and create robot and scene.

        Raises:
            AlreadyLaunched: The environment is already launched (also a RuntimeError).
        """
        if self._pyrep is not None:
            raise AlreadyLaunched("The environment is already launched. Call `shutdown()` before another `launch()`.")
        self._pyrep = PyRep(MODELS[self._robot_setup])
        self._pyrep.launch(str(Path(DIR_PATH) / TTT_FILE), headless=self._headless)
        try:
            self._make_scene(self._pyrep)
        except BaseException:
            self.shutdown()
            raise

    def _make_scene(self, pyrep: PyRep) -> None:
        simulator = Simulator.current()
        simulator.planning = PlannerConfig(max_velocity=self._arm_max_velocity, max_acceleration=self._arm_max_acceleration)
        arm_class, gripper_class, _ = SUPPORTED_ROBOTS[self._robot_setup]
        arm = arm_class(0, self._arm_max_velocity, self._arm_max_acceleration)
        self._robot = Robot(arm, gripper_class())
        if self._randomize_every is None:
            self._scene = Scene(pyrep, self._robot, self._obs_config, self._robot_setup)
        else:
            self._scene = DomainRandomizationScene(
                pyrep,
                self._robot,
                self._obs_config,
                self._robot_setup,
                self._randomize_every,
                self._frequency,
                self._visual_randomization_config,
                self._dynamics_randomization_config,
            )
        self._action_mode.arm_action_mode.set_control_mode(self._robot)

    def shutdown(self) -> None:
        """Close the simulator. Further calls have no effect; `launch` starts it again."""
        if self._pyrep is not None:
            self._pyrep.shutdown()
        self._pyrep = self._robot = self._scene = self._prev_task = None

    def __enter__(self) -> Environment:
        if self._pyrep is None:
            self.launch()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.shutdown()

    # Tasks ----------------------------------------------------------------------------------------------------------

    def get_task(self, task_class: type[Task] | str) -> TaskEnvironment:
        """Unload the previous task, load a task and return its environment. Launch the simulator if necessary.

        Args:
            task_class: The class of the task, or its name in snake case.

        Raises:
            UnknownTaskName: There is no task with this name (also a RuntimeError).
        """
        if isinstance(task_class, str):
            task_class = self._string_to_task(task_class)
        if self._pyrep is None or self._scene is None or self._robot is None:
            self.launch()
        assert self._pyrep is not None and self._robot is not None and self._scene is not None
        self._pyrep.activate()
        self._scene.unload()
        task = task_class(self._pyrep, self._robot)
        self._prev_task = task
        return TaskEnvironment(
            self._pyrep,
            self._robot,
            self._scene,
            task,
            self._action_mode,
            self._dataset_root,
            self._obs_config,
            self._static_positions,
            self._attach_grasped_objects,
            self._shaped_rewards,
        )

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

        Args:
            task_name: Name of the task.
            amount: Number of demonstrations; -1 reads all.
            variation_number: Number of the variation; -1 selects any.
            image_paths: Return paths of image files instead of images.
            random_selection: Select with the global numpy generator; otherwise in natural order.
            from_episode_number: First episode without random selection.

        Raises:
            DatasetError: There is no dataset root, or it does not contain these demonstrations (also a RuntimeError).
        """
        return get_stored_demos(
            amount,
            image_paths,
            self._stored_in(),
            variation_number,
            task_name,
            self._obs_config,
            random_selection,
            from_episode_number,
        )

    def get_task_descriptions_with_episode(self, task_name: str, episode_number: int) -> list[str]:
        """Return the instructions of a stored episode, counted through all variations.

        Raises:
            DatasetError: There is no dataset root, or no such episode (also a RuntimeError).
        """
        return read_stored_descriptions(self._stored_in(), task_name, episode_number)

    def _stored_in(self) -> str:
        if not self._dataset_root:
            raise DatasetError(
                "No dataset root was given, so there are no stored demonstrations. Pass `Environment(dataset_root=...)`."
            )
        return self._dataset_root

    # What it offers -------------------------------------------------------------------------------------------------

    @property
    def action_shape(self) -> tuple[int]:
        """Shape of an action; available after `launch()`."""
        return (self.action_size,)

    @property
    def action_size(self) -> int:
        """Number of values of an action; available after `launch()`."""
        if self._scene is None:
            raise NotLaunched("Actions have no shape before the robot is loaded. Call `launch()` or `get_task(...)` first.")
        return int(self._action_mode.action_shape(self._scene))

    def get_scene_data(self) -> dict[str, dict[str, Any] | None]:
        """Return intrinsics, extrinsics and clipping planes of each camera (None if disabled), without starting the simulator."""
        return NativeEnvironment(JointPositionActionMode(), obs_config=self._obs_config).get_scene_data()


class UnknownTaskName(TaskEnvironmentError, RuntimeError):
    """There is no task with this name."""
