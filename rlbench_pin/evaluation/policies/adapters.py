"""Simple policies: no-op, random, an adapter for functions, and the base class of agents that predict key frames."""

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
    """Keeps the joints and the gripper in their state at the start of the episode."""

    def __init__(self) -> None:
        self.action_mode = MoveArmThenGripper(JointPosition(), Discrete())
        self.obs_config = blank_observations()
        self.obs_config.joint_positions = self.obs_config.gripper_open = True
        self._still: np.ndarray | None = None

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode."""
        self._still = None

    def act(self, observation: Observation) -> np.ndarray:
        """Return joint positions [rad] and the gripper as in the first observation of the episode, shape (n + 1,)."""
        if self._still is None:
            assert observation.joint_positions is not None
            self._still = np.append(observation.joint_positions, float(observation.gripper_open or 0.0))
        return self._still.copy()


class Random:
    """Samples each action uniformly between its bounds: joint positions [rad] and the gripper."""

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
        """Return the next random action, shape (n + 1,)."""
        return self._rng.uniform(self._low, self._high)


class FunctionPolicy:
    """A policy that calls a function `observations -> action`.

    The function gets the observations of the gymnasium environments: a dict of the fields that are switched on, with numbers as
    float32 of shape (n,), and unchanged images.

    Args:
        function: Function that returns an action of `action_mode`, shape (n,).
        action_mode: Action mode of the policy.
        obs_config: Observations that the function gets.
        begin: Called with the instruction at the start of each episode; None for a function without memory.
        max_steps: Suggested maximum number of actions of an episode; None suggests no number.

    Raises:
        PolicySettingsError: The action mode or the observations are not of this package.
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
                raise InvalidValue(name, value, "has to be a function", "Pass a callable object.")
        self._function, self._begin = function, begin

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode: call `begin` with the instruction."""
        if self._begin is not None:
            self._begin(instruction)

    def act(self, observation: Observation) -> np.ndarray:
        """Return the action of the function, shape (n,)."""
        return np.asarray(self._function(as_dict(observation)))


def as_dict(observation: Observation) -> dict[str, np.ndarray]:
    """Return the fields of an observation that are not None, numbers as float32 of shape (n,), images unchanged."""
    fields = {name: np.asarray(value) for name, value in vars(observation).items() if value is not None and name != "misc"}
    return {name: value if value.ndim > 1 else np.atleast_1d(value).astype(np.float32) for name, value in fields.items()}


@dataclass(frozen=True, eq=False)
class KeyFrame:
    """The next pose of the tip, and the state of the gripper after the motion to it."""

    pose: np.ndarray
    """Pose of the tip in the world, shape (7,): x, y, z [m], qx, qy, qz, qw; the quaternion is normalised."""
    is_open: bool
    """Whether the gripper is open after the motion."""
    ignore_collisions: bool = False
    """Whether the motion to the pose ignores collisions."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for an invalid pose or truth value."""
        object.__setattr__(self, "pose", as_pose(self.pose, "The pose of a key frame"))
        object.__setattr__(self, "is_open", as_flag(self.is_open, "is_open"))
        object.__setattr__(self, "ignore_collisions", as_flag(self.ignore_collisions, "ignore_collisions"))


class KeyFramePolicy(ABC):
    """Base class of agents that predict key frames. Each action plans a motion to a pose, then moves the gripper.

    Subclasses implement `predict`. If there is no collision-free motion, the motion is planned without collision checks.

    Args:
        obs_config: Observations that `predict` gets.
        max_steps: Suggested maximum number of key frames of an episode.
    """

    def __init__(self, obs_config: ObservationConfig, max_steps: int | None = 25) -> None:
        self.action_mode = key_frame_mode()
        self.obs_config, self.max_steps = obs_config, max_steps
        self.instruction = ""

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode. Subclasses with memory reset it here."""
        self.instruction = instruction

    @abstractmethod
    def predict(self, observation: Observation, instruction: str) -> KeyFrame:
        """Return the next key frame.

        Args:
            observation: The observation, with the arm stationary.
            instruction: The instruction of the episode.
        """

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next key frame as an action, shape (9,): the pose, the gripper, and whether collisions are ignored."""
        frame = self.predict(observation, self.instruction)
        return np.concatenate([frame.pose, [float(frame.is_open), float(frame.ignore_collisions)]])
