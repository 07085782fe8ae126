"""A policy for reach_target: the tip goes straight to the ball. Evaluate it as `my_policy.py:GoThere`, from this folder.

What to look for: the policy declares its action mode and its observations.
"""

from __future__ import annotations

import numpy as np

from rlbench_pin import Discrete, EndEffectorVelocity, MoveArmThenGripper, Observation, ObservationConfig
from rlbench_pin.evaluation import PolicyContext


class GoThere:
    """Tip velocities towards the ball [m/s]; `gain` is the fraction of the distance to cover per second [1/s]."""

    def __init__(self, gain: float = 3.0) -> None:
        self.gain, self.action_mode = gain, MoveArmThenGripper(EndEffectorVelocity(), Discrete())
        self.obs_config = ObservationConfig()
        self.obs_config.set_all(False)
        self.obs_config.gripper_pose = self.obs_config.task_low_dim_state = True

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode; this policy remembers nothing."""

    def act(self, observation: Observation) -> np.ndarray:
        way = observation.task_low_dim_state[:3] - observation.gripper_pose[:3]
        return np.concatenate([np.clip(self.gain * way, -0.3, 0.3), np.zeros(3), [1.0]])
