"""Tasks as environments of LeRobot: `make_env(n_envs, use_async_envs)` for its environment hub.

LeRobot reads the observation keys `pixels` and `agent_pos`, the attributes `task`, `task_description` and
`_max_episode_steps`, and `info["is_success"]`. See `examples/lerobot/env.py` for the file to upload to the hub.
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
"""Environment variable with the default tasks of `make_env`, separated by commas."""
NEW_ROLLOUT = "lerobot_new_rollout"
"""Option that LeRobot passes to `reset`; environments ignore it."""
AUTORESET = AutoresetMode.SAME_STEP
"""Autoreset mode: LeRobot up to 0.4 reads success only from `final_info`, which exists only in this mode."""

Spaces = tuple[gymnasium.Space[Any], gymnasium.Space[Any]]


@runtime_checkable
class NamesTasks(Protocol):
    """Settings of LeRobot with task names."""

    task: str | None


@runtime_checkable
class LimitsEpisodes(Protocol):
    """Settings of LeRobot with the length of episodes."""

    episode_length: int | None


class LeRobotEnv(gymnasium.Env[dict[str, Any], np.ndarray], EzPickle):
    """One task as an environment for LeRobot.

    Observations: `pixels`, a dict of images uint8 (h, w, 3) by camera, and `agent_pos`, float32 (n + 1,): joint positions [rad]
    and 1 or 0 for an open or closed gripper. Actions are the actions of recorded demonstrations: absolute joint positions and a
    gripper value, above 0.5 to open.

    Args:
        task: Name of the task, or a task file.
        max_episode_steps: Number of steps after which an episode is truncated.
        variation: Variation of all episodes; -1 draws one for each episode from the seed.
        cameras: Names of the cameras.
        image_size: Width and height of images [px], as in the training of the policy.
        render_mode: `rgb_array` or `human`.
        action_mode: Action mode; None selects the actions above.
        renderer: Renderer of images: `cpu`, `egl` or `auto`.
        like: Observation and action space, if known; then the world is built at its first use, otherwise at once.

    Attributes:
        task: Name of the task.
        task_description: Instruction of the present episode.
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
        """The wrapped environment; it is built at the first access."""
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
        """Run one action; the episode is truncated after its maximum number of steps."""
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
        """Close the world. Further calls have no effect; a later use of the environment builds it again."""
        env, self._env = self._env, None
        if env is not None:
            env.close()


def make_env(
    n_envs: int = 1, use_async_envs: bool = False, cfg: Any = None, *, tasks: Sequence[str] | None = None, **settings: Any
) -> dict[str, dict[int, gymnasium.vector.VectorEnv[Any, Any, Any]]]:
    """Return `{suite: {task id: vector environment}}`; each world is built at its first use.

    Args:
        n_envs: Number of environments in each vector environment.
        use_async_envs: Run each environment in its own process, spawned at its first use; otherwise all in this process.
        cfg: Environment settings of LeRobot; `task` (names separated by commas) and `episode_length` are used.
        tasks: Names of tasks, or task files, which get the ids after those of all names. Without `tasks`, the tasks of `cfg`,
            of the environment variable `RLBENCH_PIN_TASKS`, or all tasks.
        settings: Further arguments of `LeRobotEnv`.

    Raises:
        UnknownName: There is no task with this name.
        TaskError: A task file cannot be loaded.
        InvalidArgument: `n_envs` is not an integer >= 1 (also a TaskEnvironmentError), or another argument is invalid.
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
