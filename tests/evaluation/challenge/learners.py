"""Learners for the tests of the challenge, good ones and bad ones; each runs in a process of its own."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rlbench_pin.environment import Discrete, JointPosition, MoveArmThenGripper, ObservationConfig
from rlbench_pin.evaluation import Demonstration, PolicyContext, TrainingTask
from rlbench_pin.observation import Observation


def blank() -> ObservationConfig:
    """Nothing but what the arm measures."""
    config = ObservationConfig(joint_poses=False)
    config.set_all(False)
    config.joint_positions = config.gripper_open = True
    return config


class Still:
    """Its policy holds the arm where the demonstrations end, so that it needs them; what it has learned is counted.

    Args:
        fault: What is wrong with it.
    """

    def __init__(self, fault: str = "") -> None:
        self.action_mode, self.obs_config, self.max_steps = MoveArmThenGripper(JointPosition(), Discrete()), blank(), 5
        self.fault, self.learned, self.end = fault, 0, np.zeros(8)
        if fault == "masks":
            self.obs_config.front_camera.mask = True
        if fault == "state":
            self.obs_config.task_low_dim_state = True
        if fault == "distances":
            self.obs_config.model = replace(self.obs_config.model, world_distances=3)
        if fault == "pictures":
            self.pictures = "none"

    def meta_train(self, tasks: Sequence[TrainingTask]) -> Mapping[str, Any] | None:
        """Count the tasks."""
        if self.fault == "train":
            raise ZeroDivisionError("nothing to practise")
        return {"tasks": [task.name for task in tasks], "weights": np.full((2, 2), 0.5)}

    def recall(self, learned: Mapping[str, Any]) -> None:
        """See that all arrived."""
        assert learned["weights"].tolist() == [[0.5, 0.5], [0.5, 0.5]]
        self.learned = len(learned["tasks"])

    def adapt(self, demonstrations: Sequence[Demonstration]) -> Any:
        """Keep where the last demonstration ended."""
        assert self.learned > 1
        if self.fault == "adapt":
            raise ZeroDivisionError("nothing to learn")
        if self.fault == "no policy":
            return 3
        if self.fault == "other":
            other = Still()
            other.obs_config.joint_velocities = True
            return other
        last = demonstrations[-1].observations[-1]
        assert last.joint_positions is not None
        self.end = np.append(last.joint_positions, last.gripper_open or 0.0)
        return self

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Begin an episode."""
        assert instruction

    def act(self, observation: Observation) -> np.ndarray:
        """Go there."""
        if self.fault == "exit":
            os._exit(3)
        if self.fault == "nan":
            return np.full(8, np.nan)
        if self.fault == "hang":
            time.sleep(1000.0)
        return self.end


class MadeForPanda(Still):
    """Was made for the joints of the Panda."""

    joint_names = tuple(f"panda_joint{number}" for number in range(1, 8))
