"""Simple policies: no-op, random, functions as policies, and the base class of agents that predict key frames."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rlbench_pin.environment.actions import ActionMode, Discrete, JointPosition, MoveArmThenGripper
from rlbench_pin.environment.observations import ObservationConfig
from rlbench_pin.environment.presets import key_frame_mode
from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.evaluation.policies.settings import PolicySettings, blank_observations
from rlbench_pin.observation import Observation
from rlbench_pin.values import as_flag, as_pose


class Noop:
    """Holds the joints and the gripper as they were at the start of the episode."""

    def __init__(self) -> None:
        self.action_mode = MoveArmThenGripper(JointPosition(), Discrete())
        self.obs_config = blank_observations()
        self.obs_config.joint_positions = self.obs_config.gripper_open = True
        self._still: np.ndarray | None = None

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Forget where the arm was."""
        self._still = None

    def act(self, observation: Observation) -> np.ndarray:
        """Return joint positions [rad] and the gripper as in the first observation of the episode, shape (n + 1,)."""
        if self._still is None:
            assert observation.joint_positions is not None
            self._still = np.append(observation.joint_positions, float(observation.gripper_open or 0.0))
        return self._still.copy()


class Random:
    """Draws each action uniformly between its bounds: joint positions [rad] and the gripper."""

    def __init__(self) -> None:
        self.action_mode = MoveArmThenGripper(JointPosition(), Discrete())
        self.obs_config = blank_observations()
        self._low = self._high = np.zeros(0)
        self._rng = np.random.default_rng(0)

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Seed the generator from the context."""
        self._rng = np.random.default_rng(context.seed)
        self._low, self._high = np.array(context.action_low), np.array(context.action_high)

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next draw, shape (n + 1,)."""
        return self._rng.uniform(self._low, self._high)


class FunctionPolicy:
    """A policy made of a function `observations -> action`.

    The function is given what gymnasium's environments deliver: a dict of the fields that are switched on, numbers as float32 of
    shape (n,), images as they are.

    Args:
        function: What acts; an action is an array of shape (n,), as `action_mode` takes it.
        action_mode: What actions mean.
        obs_config: What the function is given.
        begin: Called with the instruction at the start of each episode; None where nothing is remembered.
        max_steps: Actions of an episode that it suggests.

    Raises:
        PolicySettingsError: Action mode or observations are not of this package.
    """

    def __init__(
        self,
        function: Callable[[dict[str, np.ndarray]], Any],
        action_mode: ActionMode,
        obs_config: ObservationConfig,
        begin: Callable[[str], None] | None = None,
        max_steps: int | None = None,
    ) -> None:
        PolicySettings.of(action_mode, obs_config, max_steps)  # raises where they are not of this package
        self.action_mode, self.obs_config, self.max_steps = action_mode, obs_config, max_steps
        for name, value in (("function", function), ("begin", begin)):
            if not callable(value) and not (name == "begin" and value is None):
                raise InvalidValue(name, value, "has to be a function")
        self._function, self._begin = function, begin

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Tell the function that an episode begins."""
        if self._begin is not None:
            self._begin(instruction)

    def act(self, observation: Observation) -> np.ndarray:
        """Return what the function returns."""
        return np.asarray(self._function(as_dict(observation)))


def as_dict(observation: Observation) -> dict[str, np.ndarray]:
    """Return the fields of an observation that are there, numbers as float32 of shape (n,), images as they are."""
    fields = {name: np.asarray(value) for name, value in vars(observation).items() if value is not None and name != "misc"}
    return {name: value if value.ndim > 1 else np.atleast_1d(value).astype(np.float32) for name, value in fields.items()}


@dataclass(frozen=True, eq=False)
class KeyFrame:
    """Next pose of the gripper, and its action there."""

    pose: np.ndarray
    """Pose of the tip in the world, shape (7,): x, y, z [m], qx, qy, qz, qw; brought to unit length."""
    is_open: bool
    """Whether the gripper is open afterwards."""
    ignore_collisions: bool = False
    """Whether the motion there may touch objects."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for an invalid pose or truth value."""
        object.__setattr__(self, "pose", as_pose(self.pose, "The pose of a key frame"))
        object.__setattr__(self, "is_open", as_flag(self.is_open, "is_open"))
        object.__setattr__(self, "ignore_collisions", as_flag(self.ignore_collisions, "ignore_collisions"))


class KeyFramePolicy(ABC):
    """Base of agents that predict key frames: each call is a planned motion to a pose, then the gripper.

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
            observation: The observation, with the arm stationary.
            instruction: What to do.
        """

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next key frame as an action, shape (9,): the pose, the gripper, and whether collisions are ignored."""
        frame = self.predict(observation, self.instruction)
        return np.concatenate([frame.pose, [float(frame.is_open), float(frame.ignore_collisions)]])
