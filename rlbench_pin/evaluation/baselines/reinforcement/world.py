"""A task as the algorithms meet it: features, numbers between -1 and 1, a reward that is sparse or shaped."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np

from rlbench_pin.environment import Environment, JointPositionActionMode, TaskEnvironment, low_dim_config
from rlbench_pin.errors import ResetError, TaskEnvironmentError
from rlbench_pin.evaluation.baselines.reinforcement.features import TICKS, as_command, features
from rlbench_pin.observation import Demo, Observation

TRAINING_SEEDS = 2**31
"""Training draws the seeds of its episodes below this, so that it never meets one of an evaluation."""
VALIDATION_SEED = 2**52
"""Episode i of a look at a policy has this seed plus i."""
SHAPED = 0.1
"""The share of the task's own reward that is paid: with it an episode that fails costs about what success pays."""
TRIES = 10
"""Seeds that are drawn before a task that cannot be placed is an error."""


class LearningEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """One task for Stable-Baselines3, of any variation. A step is a decision of `TICKS` control ticks; `info` holds `is_success`.

    Success pays 1. With `shaped` every decision pays `SHAPED` of the task's own reward, too. Success and failure end an episode.

    Args:
        task: Name of the task.
        shaped: Whether the task's own reward is paid.
        longest: Decisions of an episode at most.

    Raises:
        TaskEnvironmentError: The task has no reward of its own, and `shaped` is asked for.
    """

    def __init__(self, task: str, shaped: bool, longest: int) -> None:
        self._environment = Environment(JointPositionActionMode(), obs_config=low_dim_config())
        self._shaped, self._longest, self._count = shaped, longest, 0
        try:
            self.task: TaskEnvironment = self._environment.get_task(task)
            self.task.set_variation(0)
            _, seen = self.task.reset(seed=0)
            if shaped and self.task.task.reward() is None:
                raise TaskEnvironmentError(f"'{task}' has no shaped reward. Leave out `--shaped`, or use --demonstrations.")
        except BaseException:
            self.close()
            raise
        self._high = self.task.action_bounds()[1]
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, features(seen).shape, np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, self._high.shape, np.float32)

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode from a seed that is drawn; `options={"episode": seed}` names one.

        Raises:
            ResetError: The task could not be placed, from none of ten seeds.
        """
        super().reset(seed=seed)
        named = (options or {}).get("episode")
        for last in [False] * (TRIES - 1) + [True]:
            episode = int(self.np_random.integers(TRAINING_SEEDS)) if named is None else int(named)
            try:
                instructions, seen = self.task.reset(seed=episode, variation=-1)
                break
            except ResetError:
                if last or named is not None:
                    raise
        return self._begun(seen), {"instructions": instructions}

    def reset_to(self, demo: Demo) -> Observation:
        """Begin the episode of a demonstration and return what is observed."""
        _, seen = self.task.reset_to_demo(demo)
        self._begun(seen)
        return seen

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Act for one decision."""
        command = as_command(action, self._high)
        for _ in range(TICKS):
            seen, _, over = self.task.step(command)
            if over:
                break
        self._count += 1
        success = self.task.succeeded
        reward = float(success) + (SHAPED * (self.task.task.reward() or 0.0) if self._shaped else 0.0)
        info = {"is_success": success, "observation": seen}
        return features(seen), reward, over, not over and self._count >= self._longest, info

    def close(self) -> None:
        """Free the world."""
        self._environment.shutdown()

    def _begun(self, seen: Observation) -> np.ndarray:
        self._count = 0
        return features(seen)
