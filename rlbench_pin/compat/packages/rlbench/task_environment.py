"""`TaskEnvironment`: the environment of one task."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from pyrep.const import ObjectType
from pyrep.pyrep import PyRep
from rlbench.action_modes.action_mode import ActionMode
from rlbench.backend.robot import Robot
from rlbench.backend.scene import Scene
from rlbench.backend.task import Task
from rlbench.observation_config import ObservationConfig
from rlbench.utils import get_stored_demos
from rlbench_pin.compat.simulator import SceneRuntime, runtime_of
from rlbench_pin.environment.actions.modes import attaches_grasped
from rlbench_pin.environment.reset import MAX_RESET_ATTEMPTS
from rlbench_pin.environment.task_environment import MAX_DEMO_ATTEMPTS
from rlbench_pin.errors import (
    BoundaryError,
    DatasetError,
    DemoError,
    NotReset,
    RlbenchPinError,
    TaskEnvironmentError,
    WaypointError,
)
from rlbench_pin.observation import Demo, Observation

_DT = 0.05
_MAX_RESET_ATTEMPTS = MAX_RESET_ATTEMPTS
_MAX_DEMO_ATTEMPTS = MAX_DEMO_ATTEMPTS


class NotPlaced(TaskEnvironmentError):
    """The reset found no valid start of an episode."""

    def __init__(self, task: str, variation: int, cause: Exception) -> None:
        self.task, self.variation = task, variation
        super().__init__(f"Variation {variation} of task '{task}' could not be started: {cause}")


class DemosFailed(DemoError, RuntimeError):
    """All attempts at a live demonstration failed; `causes` has the reasons."""

    def __init__(self, task: str, variation: int, causes: Sequence[str]) -> None:
        self.causes = tuple(causes)
        text = "; ".join(f"try {i + 1}: {cause}" for i, cause in enumerate(causes))
        super().__init__(
            f"Variation {variation} of task '{task}' could not be demonstrated in {len(causes)} tries ({text}). "
            f"`rlbench-pin check {task}` shows how often that happens."
        )


class TaskEnvironment:
    """The environment of one task: `reset`, `step`, `get_demos`. `Environment.get_task` creates one.

    Args:
        pyrep: The simulator.
        robot: Arm and gripper.
        scene: World, task and robot; the task is loaded into it.
        task: The task.
        action_mode: Meaning, size and bounds of an action.
        dataset_root: Folder of stored demonstrations.
        obs_config: Contents of observations.
        static_positions: Keep the task at the pose of its scene file.
        attach_grasped_objects: Fix grasped bodies to the gripper. A setting of the gripper mode takes precedence.
        shaped_rewards: Return the shaped reward of the task.
    """

    def __init__(
        self,
        pyrep: PyRep,
        robot: Robot,
        scene: Scene,
        task: Task,
        action_mode: ActionMode,
        dataset_root: str,
        obs_config: ObservationConfig,
        static_positions: bool = False,
        attach_grasped_objects: bool = True,
        shaped_rewards: bool = False,
    ) -> None:
        self._pyrep, self._robot, self._scene, self._task = pyrep, robot, scene, task
        self._action_mode, self._dataset_root, self._obs_config = action_mode, dataset_root, obs_config
        self._static_positions, self._attach_grasped_objects = static_positions, attach_grasped_objects
        self._shaped_rewards = shaped_rewards
        self._variation_number, self._reset_called, self._succeeded = 0, False, False
        self._prev_ee_velocity: Any = None
        self._enable_path_observations = False
        scene.load(task)
        if not attaches_grasped(action_mode, attach_grasped_objects):
            scene.runtime.gripper.rely_on_friction()
        pyrep.start()

    @cached_property
    def _robot_shapes(self) -> list[Any]:
        return list(self._robot.arm.get_objects_in_tree(object_type=ObjectType.SHAPE))

    @property
    def runtime(self) -> SceneRuntime:
        """World, task and planner of rlbench_pin."""
        return self._scene.runtime

    @property
    def succeeded(self) -> bool:
        """Whether the goal was reached by the last step; False after a reset."""
        return self._succeeded

    # What it is -----------------------------------------------------------------------------------------------------

    def get_name(self) -> str:
        """Return the snake-case task name."""
        return str(self._task.get_name())

    def variation_count(self) -> int:
        """Return the number of variations of the task."""
        return int(self._task.variation_count())

    def sample_variation(self) -> int:
        """Draw a variation from numpy's global generator, set and return it."""
        self._variation_number = int(np.random.randint(0, self.variation_count()))
        return self._variation_number

    def set_variation(self, v: int) -> None:
        """Set the variation of the next episodes; -1 selects all: any stored one, and a random one at each reset.

        Raises:
            TaskEnvironmentError: The task has no such variation.
        """
        count = self.variation_count()
        if not -1 <= v < count:
            raise TaskEnvironmentError(
                f"Task '{self.get_name()}' has no variation {v}. Choose 0 to {count - 1}, or -1 for all of them."
            )
        self._variation_number = int(v)

    def get_task_descriptions(self) -> list[str]:
        """Return the instructions of the current episode.

        Raises:
            NotReset: Before the first reset (also a RuntimeError).
        """
        return self._scene.descriptions

    # The loop -------------------------------------------------------------------------------------------------------

    def reset(self, demo: Demo | None = None) -> tuple[list[str], Observation]:
        """Start an episode; all draws use the global numpy generator.

        Args:
            demo: Restore the start of this demonstration.

        Returns:
            Instructions and the first observation.

        Raises:
            TaskEnvironmentError: The task could not be placed.
        """
        self._pyrep.activate()
        self._scene.reset()
        self._scene.start_next_as(demo)
        variation = self._variation_number
        if variation < 0:
            variation = int(np.random.randint(0, self.variation_count())) if demo is None else demo.variation_number
        try:
            descriptions = self._scene.init_episode(
                variation,
                randomly_place=not self._static_positions,
                max_attempts=_MAX_RESET_ATTEMPTS,
                place_demo=demo is not None,
            )
        except (BoundaryError, WaypointError) as error:
            raise NotPlaced(self.get_name(), variation, error) from error
        self._reset_called, self._succeeded = True, False
        return descriptions, self._scene.get_observation()

    def get_observation(self) -> Observation:
        """Return an observation without a simulation step."""
        self._pyrep.activate()
        return self._scene.get_observation()

    def step(self, action: Any) -> tuple[Observation, float, bool]:
        """Execute one action to its end, or until the episode ends.

        Returns:
            Observation, reward, and whether the episode has ended by success or by the fail conditions. There is no automatic
            reset.

        Raises:
            NotReset: Before the first reset (also a RuntimeError).
            InvalidActionError: The action is invalid; the world has not changed.
            NoShapedReward: Shaped rewards are on and the task has none (also a RuntimeError).
        """
        if not self._reset_called:
            raise NotReset("step")
        self._pyrep.activate()
        with runtime_of(self._scene).acting() as result:
            self._action_mode.action(self._scene, action)
        self._succeeded = result.success
        reward = result.reward(self._shaped_rewards)
        return self._scene.get_observation(), reward, result.over

    # Demonstrations -------------------------------------------------------------------------------------------------

    def get_demos(
        self,
        amount: int,
        live_demos: bool = False,
        image_paths: bool = False,
        callable_each_step: Callable[[Observation], None] | None = None,
        max_attempts: int = _MAX_DEMO_ATTEMPTS,
        random_selection: bool = True,
        from_episode_number: int = 0,
    ) -> list[Demo]:
        """Return demonstrations of the current variation: plan them now, or read stored ones.

        Args:
            amount: Number of demonstrations; -1 reads all stored ones.
            live_demos: Plan them now; otherwise read them from the dataset root.
            image_paths: Do not read images (stored demonstrations).
            callable_each_step: Function that is called with each recorded observation.
            max_attempts: Maximum number of attempts per live demonstration.
            random_selection: Select stored demonstrations at random.
            from_episode_number: First stored episode without random selection.

        Raises:
            RuntimeError: There is no dataset root, stored data are missing or damaged, or all attempts of a live one failed.
        """
        if live_demos:
            return self._get_live_demos(amount, callable_each_step, max_attempts)
        if not self._dataset_root:
            raise DatasetError("No dataset root was given. Pass `Environment(dataset_root=...)`, or `live_demos=True`.")
        name, variation = self.get_name(), self._variation_number
        settings = (amount, image_paths, self._dataset_root, variation, name, self._obs_config)
        stored = get_stored_demos(*settings, random_selection, from_episode_number)
        for demo in stored:
            self._scene.remember_start(demo)
        return stored

    def _get_live_demos(
        self, amount: int, callable_each_step: Callable[[Observation], None] | None = None, max_attempts: int = _MAX_DEMO_ATTEMPTS
    ) -> list[Demo]:
        if amount < 0:
            raise TaskEnvironmentError(f"The amount of live demonstrations has to be at least 0, not {amount}.")
        return [self._live_demo(callable_each_step, max_attempts) for _ in range(amount)]

    def _live_demo(self, callable_each_step: Callable[[Observation], None] | None, max_attempts: int) -> Demo:
        causes = []
        for _ in range(max_attempts):
            try:
                self.reset()
                demo: Demo = self._scene.get_demo(callable_each_step=callable_each_step)
                self._scene.sign(demo)
                return demo
            except RlbenchPinError as error:
                causes.append(str(error))
        raise DemosFailed(self.get_name(), self._variation_number, causes)

    def reset_to_demo(self, demo: Demo) -> tuple[list[str], Observation]:
        """Restore the start of a demonstration from its seed and its snapshot.

        Raises:
            TaskEnvironmentError: The demonstration is of another task, or contains no usable seed.
        """
        self.set_variation(demo.variation_number)
        self._scene.start_next_as(demo)
        return self.reset(demo)
