"""Environment and settings of the reinforcement learning baselines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import gymnasium
import numpy as np

from rlbench_pin.environment import Environment, JointPositionActionMode, TaskEnvironment, low_dim_config
from rlbench_pin.errors import InvalidArgument, ResetError, TaskEnvironmentError, UnknownName
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_flag, as_seed, as_whole

MIN_CHECKPOINT_STEPS = 8
"""Minimum number of decisions of a segment in one environment: SAC learns after this number."""
Algorithm = Literal["ppo", "sac"]
ALGORITHMS = ("ppo", "sac")
EPISODE_STEPS: Mapping[str, int] = {"reach_target": 30}
"""Decisions of a training episode for tasks that need fewer decisions."""
LONG_EPISODE = 50
"""Decisions of a training episode for all other tasks: 7.5 s."""
CHECKPOINT_STEPS = 2048
"""Number of decisions between two checkpoints. Each segment starts with new episodes and its own generators."""


@dataclass(frozen=True)
class ReinforcementConfig:
    """Settings of reinforcement learning on one task.

    Raises:
        UnknownName: There is no such algorithm.
        InvalidArgument: A number is out of range.
    """

    algorithm: Algorithm
    """PPO or SAC of Stable-Baselines3."""
    task: str
    """Name of the task."""
    steps: int = 20_000
    """Number of training decisions, rounded up to whole segments."""
    shaped: bool = False
    """Use the shaped reward of the task at each step, and 1 for success; otherwise only 1 for success."""
    demonstrations: int = 0
    """Number of demonstrations of the planner: half of each batch of SAC, the initial policy of PPO."""
    imitation_steps: int = 3000
    """Number of batches for imitation of the demonstrations by the initial policy."""
    seed: int = 0
    """Seed of initial weights, episodes, exploration and batches."""
    workers: int = 1
    """Number of environments, each in its own process if there are several. It changes the result of a training."""
    device: str = "cpu"
    """Device of torch: `cpu`, `cuda`, `cuda:1`."""
    episode_steps: int | None = None
    """Maximum number of decisions of a training episode; None is 30 for `reach_target` and 50 for others."""
    checkpoint_steps: int = CHECKPOINT_STEPS
    """Number of decisions between two checkpoints, rounded down to a multiple of the workers; PPO learns once per segment."""
    validate_every: int = 2
    """Number of segments between two validations of the most likely action."""
    validation_episodes: int = 20
    """Number of episodes of each validation; their seeds are fixed and do not occur in training."""

    def __post_init__(self) -> None:
        """Check every number."""
        if self.algorithm not in ALGORITHMS:
            raise UnknownName("algorithm", str(self.algorithm), ALGORITHMS)
        for name in ("steps", "workers", "checkpoint_steps", "imitation_steps", "validate_every", "validation_episodes"):
            as_whole(getattr(self, name), name, InvalidArgument, least=1)
        as_whole(self.demonstrations, "demonstrations", InvalidArgument, least=0)
        as_flag(self.shaped, "shaped", InvalidArgument)
        as_seed(self.seed, "seed", InvalidArgument)
        if self.checkpoint_steps < MIN_CHECKPOINT_STEPS * self.workers:
            hint = f"has to be at least {MIN_CHECKPOINT_STEPS} for each of the {self.workers} environments"
            raise InvalidArgument("checkpoint_steps", self.checkpoint_steps, hint)
        if self.episode_steps is None:
            object.__setattr__(self, "episode_steps", EPISODE_STEPS.get(self.task, LONG_EPISODE))
        as_whole(self.episode_steps, "episode_steps", InvalidArgument, least=1)

    @property
    def longest(self) -> int:
        """Maximum number of decisions of a training episode."""
        assert self.episode_steps is not None
        return self.episode_steps

    @property
    def segment(self) -> int:
        """Steps between two checkpoints, a multiple of the environments."""
        return self.checkpoint_steps // self.workers * self.workers

    @property
    def segments(self) -> int:
        """Number of segments."""
        return -(-self.steps // self.segment)

    def identity(self) -> dict[str, Any]:
        """Return the settings that a resumed training must share: all but its length, its device and its validation."""
        names = (
            "algorithm",
            "task",
            "shaped",
            "demonstrations",
            "imitation_steps",
            "seed",
            "workers",
            "episode_steps",
            "checkpoint_steps",
        )
        return {name: getattr(self, name) for name in names}


REACH = 0.05
"""Maximum joint difference per control tick [rad]; equal to 1 rad/s."""
EPSILON = 1e-4
"""Added to the variances of features, so that the divisor is at least 1 cm or 0.01 rad."""
TICKS = 3
"""Control ticks per decision: 0.15 s. Fewer decisions per episode make learning faster."""


def features(observation: Observation) -> np.ndarray:
    """Return the inputs of the networks.

    Args:
        observation: Observation with the low-dimensional fields.

    Returns:
        Joint positions [rad], gripper opening, tip pose, task state, and the first position of the state relative to the tip
        [m], in this order: float32, shape (joints + 11 + size of the state,).
    """
    tip = np.asarray(observation.gripper_pose, dtype=np.float64)
    state = np.asarray(observation.task_low_dim_state, dtype=np.float64)
    joints = np.asarray(observation.joint_positions, dtype=np.float64)
    gripper = float(observation.gripper_open or 0.0)
    return np.concatenate([joints, [gripper], tip, state, state[:3] - tip[:3]]).astype(np.float32)


def as_command(unit: FloatArray, high: FloatArray) -> FloatArray:
    """Return the action of `JointPositionActionMode` for an action of the learner.

    Args:
        unit: One difference per joint, then the gripper (open above 0), between -1 and 1, shape (joints + 1,).
        high: Upper bounds of the action, shape (joints + 1,); the last is the position of an open finger [m].
    """
    values = np.clip(np.asarray(unit, dtype=np.float64), -1.0, 1.0)
    return np.append(REACH * values[:-1], high[-1] if values[-1] > 0.0 else 0.0)


def as_unit(joints: FloatArray, target: FloatArray, is_open: bool) -> FloatArray:
    """Return the action of the learner, between -1 and 1, that moves the arm towards joint positions.

    Args:
        joints: Current joint positions [rad].
        target: Joint positions after one decision [rad].
        is_open: Whether to open the gripper.
    """
    return np.append(np.clip((target - joints) / (TICKS * REACH), -1.0, 1.0), 1.0 if is_open else -1.0)


TRAINING_SEEDS = 2**31
"""Upper bound of the seeds of training episodes; seeds of validation are larger."""
VALIDATION_SEED = 2**52
"""Seed of episode 0 of a validation; episode i has this seed plus i."""
SHAPED = 0.1
"""Factor of the shaped reward of the task; the sum over a failed episode is then about as large as the reward of success."""
TRIES = 10
"""Number of seeds that a reset tries before it raises `ResetError`."""


class LearningEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """One task for Stable-Baselines3, with all variations. A step is one decision of `TICKS` control ticks.

    `info` contains `is_success`. Success gives a reward of 1. With `shaped`, each decision also gives `SHAPED` times the shaped
    reward of the task. Success and failure end an episode.

    Args:
        task: Name of the task.
        shaped: Use the shaped reward of the task.
        longest: Maximum number of decisions of an episode.

    Raises:
        TaskEnvironmentError: `shaped` is True, and the task has no shaped reward.
    """

    def __init__(self, task: str, shaped: bool, longest: int) -> None:
        self._environment = Environment(JointPositionActionMode(), obs_config=low_dim_config())
        self._shaped, self._longest, self._count = shaped, longest, 0
        try:
            self.task: TaskEnvironment = self._environment.get_task(task)
            self.task.set_variation(0)
            _, seen = self.task.reset(seed=0)
            if shaped and self.task.task.reward() is None:
                raise TaskEnvironmentError(f"'{task}' has no shaped reward. Omit `--shaped`, or use `--demonstrations`.")
        except BaseException:
            self.close()
            raise
        self._high = self.task.action_bounds()[1]
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, features(seen).shape, np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, self._high.shape, np.float32)

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        """Start an episode with a random seed, or with that of `options={"episode": seed}`.

        Raises:
            ResetError: The task cannot be placed with the given seed, or with any of ten random seeds.
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
        """Start the episode of a demonstration and return the first observation."""
        _, seen = self.task.reset_to_demo(demo)
        self._begun(seen)
        return seen

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Execute one decision of `TICKS` control ticks, or fewer if the episode ends."""
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
        """Close the simulation."""
        self._environment.shutdown()

    def _begun(self, seen: Observation) -> np.ndarray:
        """Set the number of decisions to 0, and return the features of the first observation."""
        self._count = 0
        return features(seen)
