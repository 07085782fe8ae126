"""Tasks of rlbench_pin as environments of LeRobot: `lerobot-eval --env.type=rlbench_pin --env.task=reach_target`.

Importing this package registers the settings with LeRobot and the id `rlbench_pin/LeRobot-v0` with gymnasium.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig
from lerobot.utils.constants import ACTION, OBS_IMAGES, OBS_STATE

from rlbench_pin.gym import LeRobotEnv

GYM_ID = "rlbench_pin/LeRobot-v0"
JOINTS = 7
"""Number of joints of the Panda; states and actions have one more value, for the gripper."""


@EnvConfig.register_subclass("rlbench_pin")
@dataclass
class RlbenchPinEnv(EnvConfig):
    """Settings `--env.*` of a task.

    Names are those of `rlbench-pin dataset export lerobot`: `observation.state` and `action` are joint positions [rad] and the
    gripper, 1 open, both of shape (8,); `observation.images.<camera>` is an image.
    """

    task: str | None = "reach_target"
    """Name of the task, or path of a task file."""
    fps: int = 20
    """Actions per second, as in recordings. It informs LeRobot; an action always takes 0.05 s."""
    episode_length: int = 300
    """Number of actions after which an episode is truncated."""
    cameras: list[str] = field(default_factory=lambda: ["front", "wrist"])
    """Cameras of left_shoulder, right_shoulder, overhead, wrist and front; use those of the training of the policy."""
    observation_height: int = 128
    """Height of images [px]; use that of the training."""
    observation_width: int = 128
    """Width of images [px]; use that of the training."""
    variation: int = -1
    """Variation of all episodes; -1 draws one for each episode from the seed."""

    def __post_init__(self) -> None:
        """Set the features of observations and actions, and their names for policies."""
        shape = (self.observation_height, self.observation_width, 3)
        self.features = {
            ACTION: PolicyFeature(type=FeatureType.ACTION, shape=(JOINTS + 1,)),
            "agent_pos": PolicyFeature(type=FeatureType.STATE, shape=(JOINTS + 1,)),
            **{f"pixels/{name}": PolicyFeature(type=FeatureType.VISUAL, shape=shape) for name in self.cameras},
        }
        images = {f"pixels/{name}": f"{OBS_IMAGES}.{name}" for name in self.cameras}
        self.features_map = {ACTION: ACTION, "agent_pos": OBS_STATE, **images}

    @property
    def package_name(self) -> str:
        """Package that registers the id."""
        return __name__

    @property
    def gym_id(self) -> str:
        """Id of gymnasium; the task is one of its arguments."""
        return GYM_ID

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """Arguments of the environment."""
        return {
            "task": self.task,
            "episode_length": self.episode_length,
            "cameras": self.cameras,
            "image_size": (self.observation_width, self.observation_height),
            "variation": self.variation,
        }


def make_environment(
    task: str, episode_length: int, cameras: Sequence[str], image_size: tuple[int, int], variation: int
) -> LeRobotEnv:
    """Return an environment.

    `gymnasium.make` consumes an argument `max_episode_steps`, so the argument is `episode_length` here.
    """
    return LeRobotEnv(task, max_episode_steps=episode_length, cameras=cameras, image_size=image_size, variation=variation)


# Without wrappers: LeRobot looks for the attribute `task_description` on what `gymnasium.make` returns.
gymnasium.register(
    id=GYM_ID, entry_point=f"{__name__}:{make_environment.__name__}", order_enforce=False, disable_env_checker=True
)
