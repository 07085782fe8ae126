"""Policies for the tests of the runner, good ones and bad ones; each runs in a process of its own."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import numpy as np

from rlbench_pin.environment import Discrete, EndEffectorPoseViaPlanning, JointPosition, MoveArmThenGripper, ObservationConfig
from rlbench_pin.evaluation.policies import PolicyContext
from rlbench_pin.observation import Observation


def joints_only() -> ObservationConfig:
    """Nothing but joint positions."""
    config = ObservationConfig()
    config.set_all(False)
    config.joint_positions = True
    return config


FAULTS = ("", "crash", "exit", "nan", "shape", "text", "hang")
"""What `Still` does in an episode, by the remainder of the seed that it is told."""


class Still:
    """Holds still, but for the second action of episodes in which it does something else."""

    def __init__(self) -> None:
        self.action_mode, self.obs_config = MoveArmThenGripper(JointPosition(), Discrete()), joints_only()
        self.fault, self.acts = "", 0

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Note what this episode is for."""
        assert instruction
        self.fault, self.acts = FAULTS[context.seed % len(FAULTS)], 0

    def act(self, observation: Observation) -> object:
        """Stay there; the second time, perhaps do not."""
        self.acts += 1
        if self.fault and self.acts == 2:
            return self._misbehave()
        assert observation.joint_positions is not None
        return np.append(observation.joint_positions, 1.0)

    def _misbehave(self) -> object:
        if self.fault == "crash":
            raise ZeroDivisionError("one by nothing")
        if self.fault == "exit":
            os._exit(3)
        if self.fault == "hang":
            time.sleep(1000.0)
        bad: dict[str, object] = {"nan": np.full(8, np.nan), "shape": np.zeros(5), "text": "forward"}
        return bad[self.fault]


class EndsWorker(Still):
    """Kills the process that plays the episode."""

    def act(self, observation: Observation) -> object:
        """Kill the parent of the supervisor, this process's own parent."""
        status = Path(f"/proc/{os.getppid()}/stat").read_text()
        os.kill(int(status.rpartition(")")[2].split()[1]), signal.SIGKILL)
        return super().act(observation)


class WrongShape(Still):
    """Returns actions with too few numbers."""

    def act(self, observation: Observation) -> object:
        """Return five numbers."""
        return np.zeros(5)


class Poses:
    """Asks for the same tip pose again and again, one that the workspace does not have."""

    def __init__(self) -> None:
        self.action_mode, self.obs_config = MoveArmThenGripper(EndEffectorPoseViaPlanning(), Discrete()), joints_only()

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Nothing to forget."""

    def act(self, observation: Observation) -> np.ndarray:
        """Return a pose behind the wall."""
        return np.array([9.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0])
