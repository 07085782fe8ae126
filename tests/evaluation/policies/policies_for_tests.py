"""Policies that do what the instruction says, well or not; they run in processes of their own."""

from __future__ import annotations

import os
import signal
import sys
import time
from typing import Any

import numpy as np

from rlbench_pin.environment import Discrete, JointVelocity, MoveArmThenGripper, ObservationConfig
from rlbench_pin.evaluation.policies import PolicyContext
from rlbench_pin.observation import Observation


class Obedient:
    """Does what the instruction says.

    Args:
        scale: What the numbers of an action are.
        name: Printed at each reset.
    """

    def __init__(self, scale: float = 0.5, name: str = "nobody") -> None:
        self.action_mode = MoveArmThenGripper(JointVelocity(), Discrete())
        self.obs_config = ObservationConfig()
        self.obs_config.set_all(False)
        self.obs_config.joint_positions = True
        self.max_steps = 7
        self.scale, self.name, self.instruction = scale, name, ""

    def reset(self, instruction: str, context: PolicyContext) -> None:
        """Remember the instruction."""
        sys.stdout.write(f"{self.name} is asked to {instruction} with a {context.robot}\n")
        self.instruction = instruction
        if instruction == "crash at once":
            raise ValueError("not today")

    def act(self, observation: Observation) -> Any:
        """Do it."""
        wrong: dict[str, Any] = {
            "nan": np.array([0.0, np.nan]),
            "infinity": [1.0, np.inf],
            "two dimensions": np.zeros((2, 4)),
            "nothing": None,
            "nothing at all": [],
            "text": "forwards",
            "ragged": [[1.0], [1.0, 2.0]],
            "objects": [object()],
            "complex": np.ones(8) * 1j,
        }
        if self.instruction in wrong:
            return wrong[self.instruction]
        if self.instruction == "echo":
            assert observation.joint_positions is not None
            return observation.joint_positions.astype(np.float32)
        if self.instruction == "count":
            return np.array([sum(np.size(value) for value in vars(observation).values() if value is not None)])
        if self.instruction == "entries":
            return np.array([len(observation.misc), "variation_index" in observation.misc, "descriptions" in observation.misc])
        return self.misbehave()

    def misbehave(self) -> Any:
        """Do what costs an episode, or a process."""
        if self.instruction == "sleep":
            time.sleep(1000.0)
        if self.instruction == "exit":
            sys.exit(3)
        if self.instruction == "abort":
            os.kill(os.getpid(), signal.SIGSEGV)
        if self.instruction == "raise":
            raise KeyError("no such thing")
        if self.instruction == "print":
            for number in range(20_000):
                sys.stdout.write(f"line {number} {'x' * 100}\n")
            sys.stderr.write("almost done\n")
        if self.instruction == "pid":
            return np.array([os.getpid()])
        return self.scale * np.ones(8)


class MadeFor(Obedient):
    """Was made for some joints.

    Args:
        joint_names: Their names.
    """

    def __init__(self, joint_names: list[str]) -> None:
        super().__init__()
        self.joint_names = joint_names


class OwnMode(MoveArmThenGripper):
    """An action mode that would run beside the simulation."""


def foreign() -> Obedient:
    """A policy with an action mode of its own."""
    policy = Obedient()
    policy.action_mode = OwnMode(JointVelocity(), Discrete())
    return policy


def no_policy() -> dict[str, int]:
    """Something else."""
    return {"act": 1}


def broken() -> Obedient:
    """What fails when it is made."""
    raise RuntimeError("the weights are missing")


INSTANCE = Obedient(scale=0.25)
