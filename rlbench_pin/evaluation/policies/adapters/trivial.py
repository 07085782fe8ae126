"""The lower end of every table: to hold still, and to flail."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment.actions import Discrete, JointPosition, MoveArmThenGripper
from rlbench_pin.evaluation.policies.observation_description import blank_observations
from rlbench_pin.evaluation.policies.policy import PolicyContext
from rlbench_pin.observation import Observation


class Rest:
    """Holds the arm where it was at the start of the episode, and the hand as it was."""

    def __init__(self) -> None:
        self.action_mode = MoveArmThenGripper(JointPosition(), Discrete())
        self.obs_config = blank_observations()
        self.obs_config.joint_positions = self.obs_config.gripper_open = True
        self._still: np.ndarray | None = None

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Forget where the arm was."""
        self._still = None

    def act(self, observation: Observation) -> np.ndarray:
        """Return joint positions [rad] and the hand as in the first observation of the episode, shape (n + 1,)."""
        if self._still is None:
            assert observation.joint_positions is not None
            self._still = np.append(observation.joint_positions, float(observation.gripper_open or 0.0))
        return self._still.copy()


class Random:
    """Draws each action evenly between its bounds: joint positions [rad] and the hand, as `rlbench-pin check` flails."""

    def __init__(self) -> None:
        self.action_mode = MoveArmThenGripper(JointPosition(), Discrete())
        self.obs_config = blank_observations()
        self._low = self._high = np.zeros(0)
        self._rng = np.random.default_rng(0)

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin anew to draw."""
        self._rng = np.random.default_rng(context.seed)
        self._low, self._high = np.array(context.action_low), np.array(context.action_high)

    def act(self, observation: Observation) -> np.ndarray:
        """Return the next draw, shape (n + 1,)."""
        return self._rng.uniform(self._low, self._high)
