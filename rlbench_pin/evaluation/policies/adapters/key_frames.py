"""Agents of key frames: each action is the pose that the hand is to be brought to next."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from rlbench_pin.environment.observations import ObservationConfig
from rlbench_pin.environment.presets import key_frame_mode
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.observation import Observation
from rlbench_pin.values import as_flag, as_pose


@dataclass(frozen=True, eq=False)
class KeyFrame:
    """Where the hand is to be next, and what it does there."""

    pose: np.ndarray
    """Pose of the tip in the world, shape (7,): x, y, z [m], qx, qy, qz, qw; brought to unit length."""
    is_open: bool
    """Whether the hand is open afterwards."""
    ignore_collisions: bool = False
    """Whether the way there may touch things."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for what is no pose, or no truth value."""
        object.__setattr__(self, "pose", as_pose(self.pose, "The pose of a key frame"))
        object.__setattr__(self, "is_open", as_flag(self.is_open, "is_open"))
        object.__setattr__(self, "ignore_collisions", as_flag(self.ignore_collisions, "ignore_collisions"))


class KeyFramePolicy(ABC):
    """Base of agents that predict key frames: a planned motion to a pose, then the hand, for each call.

    Subclasses say what comes next. A motion that is not found without collisions is planned with them.

    Args:
        obs_config: What `predict` is given.
        max_steps: Key frames of an episode that it suggests.
    """

    def __init__(self, obs_config: ObservationConfig, max_steps: int | None = 25) -> None:
        self.action_mode = key_frame_mode()
        self.obs_config, self.max_steps = obs_config, max_steps
        self.instruction = ""

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode; subclasses that remember something forget it here."""
        self.instruction = instruction

    @abstractmethod
    def predict(self, observation: Observation, instruction: str) -> KeyFrame:
        """Return the next key frame.

        Args:
            observation: What is seen and felt, the arm at rest.
            instruction: What to do.
        """

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next key frame as an action, shape (9,): the pose, the hand, and whether collisions are ignored."""
        frame = self.predict(observation, self.instruction)
        return np.concatenate([frame.pose, [float(frame.is_open), float(frame.ignore_collisions)]])
