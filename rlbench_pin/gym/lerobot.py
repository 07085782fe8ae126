"""Tasks as LeRobot evaluates policies on them: `make_env(n_envs, use_async_envs)` as its environment hub wants it.

LeRobot takes from each environment the observation keys `pixels` and `agent_pos`, the attributes `task`, `task_description` and
`_max_episode_steps`, and `info["is_success"]`. See `examples/lerobot/env.py` for the file that goes to the hub.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, ClassVar, Protocol, runtime_checkable

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import EzPickle
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from rlbench_pin.environment.actions.modes import ActionMode, Discrete, JointPosition, MoveArmThenGripper
from rlbench_pin.environment.episode import checked_seed
from rlbench_pin.errors import InvalidArgument, InvalidCamera
from rlbench_pin.gym.environment import VISION_CAMERAS, GymnasiumEnv, GymObservation
from rlbench_pin.gym.ids import MAX_EPISODE_STEPS
from rlbench_pin.gym.vector import LazyAsyncVectorEnv
from rlbench_pin.sim import RendererName
from rlbench_pin.tasks import find_task, task_names, task_reference, usable_task_names
from rlbench_pin.values import as_flag, as_names, as_whole, items_of

SUITE = "rlbench_pin"
TASKS_VARIABLE = "RLBENCH_PIN_TASKS"
"""Environment variable with the tasks that `make_env` makes when none are given, separated by commas."""
NEW_ROLLOUT = "lerobot_new_rollout"
"""Option that LeRobot passes to `reset`; it means nothing to an environment."""
AUTORESET = AutoresetMode.SAME_STEP
"""Releases of LeRobot up to 0.4 look for success in `final_info` alone, which there is in this mode only."""

Spaces = tuple[gymnasium.Space[Any], gymnasium.Space[Any]]


@runtime_checkable
class NamesTasks(Protocol):
    """Settings of LeRobot that name tasks."""

    task: str | None


@runtime_checkable
class LimitsEpisodes(Protocol):
    """Settings of LeRobot that say how long an episode may be."""

    episode_length: int | None


class LeRobotEnv(gymnasium.Env[dict[str, Any], np.ndarray], EzPickle):
    """One task in the form that LeRobot evaluates.

    Observations: `pixels`, a dict of images uint8 (h, w, 3) by camera, and `agent_pos`, float32 (n + 1,): joint positions [rad]
    and 1 or 0 for an open or closed gripper. Actions are those of recorded demonstrations: absolute joint positions and the
    gripper, above 0.5 to open it.

    Args:
        task: Name of the task, or a task file.
        max_episode_steps: Steps after which an episode is cut off.
        variation: Variation of every episode; -1 draws one for each from the seed.
        cameras: Names of the cameras.
        image_size: Width and height of images [px]; those that the policy was trained on.
        render_mode: `rgb_array` or `human`.
        action_mode: What actions mean; None is as above.
        renderer: Renderer of images: `cpu`, `egl` or `auto`.
        like: Observation and action space, when known; then the world is built when it is first used. Otherwise at once.

    Attributes:
        task: Name of the task.
        task_description: What is asked for in the present episode.
    """

    metadata: ClassVar[dict[str, Any]] = GymnasiumEnv.metadata  # type: ignore[misc]

    def __init__(
        self,
        task: str,
        *,
        max_episode_steps: int = MAX_EPISODE_STEPS,
        variation: int = -1,
        cameras: Sequence[str] = VISION_CAMERAS,
        image_size: tuple[int, int] = (128, 128),
        render_mode: Any = "rgb_array",
        action_mode: ActionMode | None = None,
        renderer: RendererName = "cpu",
        like: Spaces | None = None,
    ) -> None:
        EzPickle.__init__(
            self, task, max_episode_steps=max_episode_steps, variation=variation, cameras=cameras, image_size=image_size,
            render_mode=render_mode, action_mode=action_mode, renderer=renderer, like=like,
        )  # fmt: skip
        max_episode_steps = as_whole(max_episode_steps, "max_episode_steps", InvalidArgument, least=1)
        cameras, name = as_names(cameras, "cameras", InvalidCamera), task_reference(find_task(task))
        if like is not None and not all(isinstance(space, gymnasium.Space) for space in items_of(like) or (None,)):
            raise InvalidArgument("like", like, "has to be the observation and the action space, or None")
        self._make = partial(
            GymnasiumEnv,
            task,
            "vision",
            render_mode,
            MoveArmThenGripper(JointPosition(), Discrete()) if action_mode is None else action_mode,
            variation=variation,
            image_size=image_size,
            renderer=renderer,
            cameras=cameras,
        )
        self._env: GymnasiumEnv | None = None
        self._max_episode_steps, self._steps, self._cameras = max_episode_steps, 0, cameras
        self.task = find_task(task).get_name() if name.endswith(".py") else name
        self.task_description, self.render_mode = "", render_mode
        self.observation_space, self.action_space = (self._space(self.world), self.world.action_space) if like is None else like

    @property
    def world(self) -> GymnasiumEnv:
        """The environment that is translated, built now if need be."""
        if self._env is None:
            self._env = self._make()
        return self._env

    def _space(self, world: GymnasiumEnv) -> spaces.Dict:
        seen, joints = world.observation_space, len(world.task_environment.runtime.description.arm_joints)
        assert isinstance(seen, spaces.Dict)
        high = np.append(np.full(joints, 2.0 * np.pi), 1.0).astype(np.float32)
        low = np.append(-high[:-1], 0.0).astype(np.float32)
        pixels = spaces.Dict({camera: seen[f"{camera}_rgb"] for camera in self._cameras})
        return spaces.Dict({"pixels": pixels, "agent_pos": spaces.Box(low, high)})

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Start an episode; see `GymnasiumEnv.reset`."""
        super().reset(seed=None if seed is None else checked_seed(seed))
        wanted = {name: value for name, value in (options or {}).items() if name != NEW_ROLLOUT}
        observation, info = self.world.reset(seed=seed, options=wanted)
        self._steps, self.task_description = 0, info["text_descriptions"][0]
        return self._translated(observation), self._with_task(info)

    def step(self, action: np.ndarray) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Run one action; the episode is cut off after the last step that it may have."""
        observation, reward, terminated, _, info = self.world.step(action)
        self._steps += 1
        truncated = not terminated and self._steps >= self._max_episode_steps
        return self._translated(observation), reward, terminated, truncated, self._with_task(info)

    def _translated(self, observation: GymObservation) -> dict[str, Any]:
        return {
            "pixels": {camera: observation[f"{camera}_rgb"] for camera in self._cameras},
            "agent_pos": np.concatenate([observation["joint_positions"], observation["gripper_open"]]),
        }

    def _with_task(self, info: dict[str, Any]) -> dict[str, Any]:
        return {**info, "task": self.task}

    def render(self) -> Any:
        """Return or show an image from the side; see `GymnasiumEnv.render`."""
        return self.world.render()

    def close(self) -> None:
        """Free the world; may be called again. Using the environment afterwards builds it again."""
        env, self._env = self._env, None
        if env is not None:
            env.close()


def make_env(
    n_envs: int = 1, use_async_envs: bool = False, cfg: Any = None, *, tasks: Sequence[str] | None = None, **settings: Any
) -> dict[str, dict[int, gymnasium.vector.VectorEnv[Any, Any, Any]]]:
    """Return `{suite: {task id: vector environment}}`; no world is built before it is used.

    Args:
        n_envs: Environments in each vector environment.
        use_async_envs: A process for each of them, spawned when first used, instead of all in this process.
        cfg: LeRobot's environment settings; of these `task`, names separated by commas, and `episode_length` are used.
        tasks: Names of tasks, or task files, which have the ids after those of all names; otherwise those of `cfg`, of the
            environment variable `RLBENCH_PIN_TASKS`, or all.
        settings: Further arguments of `LeRobotEnv`.

    Raises:
        UnknownName: No task has this name.
        TaskError: A task file cannot be loaded.
        InvalidArgument: `n_envs` is not a whole number, or less than 1 (also a TaskEnvironmentError); another argument is wrong.
    """
    as_flag(use_async_envs, "use_async_envs", InvalidArgument)
    n_envs = as_whole(n_envs, "n_envs", InvalidArgument, least=1, most=10_000)
    chosen = () if tasks is None else as_names(tasks, "tasks", InvalidArgument)
    chosen = chosen or _wanted_tasks(cfg)
    names = tuple(dict.fromkeys(task_reference(find_task(name)) for name in chosen))
    if isinstance(cfg, LimitsEpisodes) and cfg.episode_length is not None:
        settings.setdefault("max_episode_steps", cfg.episode_length)
    probe = LeRobotEnv(names[0], **settings)
    probe.close()
    settings["like"] = (probe.observation_space, probe.action_space)
    files = [name for name in names if name not in task_names()]
    ids = {name: number for number, name in enumerate((*task_names(), *files))}
    makers = {ids[name]: [partial(LeRobotEnv, name, **settings)] * n_envs for name in names}
    if use_async_envs:
        return {SUITE: {task: LazyAsyncVectorEnv(make, probe, AUTORESET) for task, make in makers.items()}}
    return {SUITE: {task: SyncVectorEnv(make, autoreset_mode=AUTORESET) for task, make in makers.items()}}


def _wanted_tasks(cfg: Any) -> tuple[str, ...]:
    asked = (cfg.task if isinstance(cfg, NamesTasks) else None) or os.environ.get(TASKS_VARIABLE, "")
    return tuple(name.strip() for name in str(asked).split(",") if name.strip()) or usable_task_names()
