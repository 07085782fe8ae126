"""One task, ready to be reset, stepped and demonstrated."""

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
    """No start of an episode was found."""

    def __init__(self, task: str, variation: int, cause: Exception) -> None:
        self.task, self.variation = task, variation
        super().__init__(f"Variation {variation} of task '{task}' could not be started: {cause}")


class DemosFailed(DemoError, RuntimeError):
    """A live demonstration failed at every try; `causes` says why."""

    def __init__(self, task: str, variation: int, causes: Sequence[str]) -> None:
        self.causes = tuple(causes)
        text = "; ".join(f"try {i + 1}: {cause}" for i, cause in enumerate(causes))
        super().__init__(
            f"Variation {variation} of task '{task}' could not be demonstrated in {len(causes)} tries ({text}). "
            f"`rlbench-pin check {task}` shows how often that happens."
        )


class TaskEnvironment:
    """The environment of one task: `reset`, `step`, `get_demos`. `Environment.get_task` makes one.

    Args:
        pyrep: The simulator.
        robot: Arm and gripper.
        scene: World, task and robot together; the task is loaded into it.
        task: The task.
        action_mode: What actions mean.
        dataset_root: Folder of stored demonstrations.
        obs_config: What observations contain.
        static_positions: Leave the task where its scene file puts it.
        attach_grasped_objects: Fix grasped bodies to the gripper, unless the gripper mode says otherwise.
        shaped_rewards: Return the task's own reward.
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
        """World, task and planner together, as the package itself uses them."""
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
        """Return how many variations the task has."""
        return int(self._task.variation_count())

    def sample_variation(self) -> int:
        """Draw a variation from numpy's global generator, set and return it."""
        self._variation_number = int(np.random.randint(0, self.variation_count()))
        return self._variation_number

    def set_variation(self, v: int) -> None:
        """Choose the variation of the next episodes; -1 means all of them: any stored one, a drawn one at each reset.

        Raises:
            TaskEnvironmentError: The task has no such variation.
        """
        count = self.variation_count()
        if not -1 <= v < count:
            raise TaskEnvironmentError(
                f"Task '{self.get_name()}' has no variation {v}: choose 0 to {count - 1}, or -1 for all of them."
            )
        self._variation_number = int(v)

    def get_task_descriptions(self) -> list[str]:
        """Return the sentences of the present episode.

        Raises:
            NotReset: Before the first reset (also a RuntimeError).
        """
        return self._scene.descriptions

    # The loop -------------------------------------------------------------------------------------------------------

    def reset(self, demo: Demo | None = None) -> tuple[list[str], Observation]:
        """Start an episode; what is drawn comes from numpy's global generator.

        Args:
            demo: Start as this demonstration did.

        Returns:
            Sentences that say what to do, and the first observation.

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
        """Observe without stepping."""
        self._pyrep.activate()
        return self._scene.get_observation()

    def step(self, action: Any) -> tuple[Observation, float, bool]:
        """Run one action, to its end or until a step of it ends the episode.

        Returns:
            Observation, reward, and whether the episode has ended: by the goal, or by the fail list. Nothing resets by itself.

        Raises:
            NotReset: Before the first reset (also a RuntimeError).
            InvalidActionError: The action was refused; the world is as it was.
            NoShapedReward: Shaped rewards are on and the task gives none (also a RuntimeError).
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
        """Return demonstrations of the present variation, stored or made now.

        Args:
            amount: Number of demonstrations; -1 is all stored ones.
            live_demos: Plan them now; otherwise read them from the dataset root.
            image_paths: Leave images unread (stored demonstrations).
            callable_each_step: Called with every recorded observation.
            max_attempts: Attempts per live demonstration.
            random_selection: Pick stored demonstrations at random.
            from_episode_number: First stored episode when not picked at random.

        Raises:
            RuntimeError: There is no dataset root, stored data are missing or damaged, or all attempts of a live one failed.
        """
        if live_demos:
            return self._get_live_demos(amount, callable_each_step, max_attempts)
        if not self._dataset_root:
            raise DatasetError("No dataset root was given. Pass `Environment(dataset_root=...)`, or ask for `live_demos=True`.")
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
            raise TaskEnvironmentError(f"Live demonstrations need an amount of at least 0, not {amount}.")
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
        """Start as a demonstration did: its seed sets up the task, its snapshot the very state.

        Raises:
            TaskEnvironmentError: The demonstration is of another task, or carries no seed that can be used.
        """
        self.set_variation(demo.variation_number)
        self._scene.start_next_as(demo)
        return self.reset(demo)
