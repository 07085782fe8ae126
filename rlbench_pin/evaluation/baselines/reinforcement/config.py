"""What is trained, how long, and with which settings of the algorithm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from rlbench_pin.errors import InvalidArgument, UnknownName
from rlbench_pin.values import as_flag, as_seed, as_whole

LEAST_LEG = 8
"""Decisions of a leg in one environment at least: SAC learns after so many."""
Algorithm = Literal["ppo", "sac"]
ALGORITHMS = ("ppo", "sac")
EPISODE_STEPS: Mapping[str, int] = {"reach_target": 30}
"""Decisions of a training episode for tasks that need fewer than others."""
LONG_EPISODE = 50
"""Decisions of a training episode for all other tasks: 7.5 s."""
LEG = 2048
"""Decisions between two check points. Each leg begins with new episodes and generators of its own."""


@dataclass(frozen=True)
class ReinforcementConfig:
    """How a task is learned by trial.

    Raises:
        UnknownName: There is no such algorithm.
        InvalidArgument: A number is out of range.
    """

    algorithm: Algorithm
    """PPO or SAC of Stable-Baselines3."""
    task: str
    """Name of the task."""
    steps: int = 20_000
    """Decisions of training, rounded up to whole legs."""
    shaped: bool = False
    """Pay the task's own reward at each step, and 1 for success; otherwise 1 for success alone."""
    demonstrations: int = 0
    """Demonstrations of the planner: half of each batch of SAC, the first policy of PPO."""
    imitation_steps: int = 3000
    """Batches from which the first policy learns to imitate demonstrations."""
    seed: int = 0
    """Of first weights, episodes, exploration and batches."""
    workers: int = 1
    """Environments at once, each in a process of its own when there are several. Another number is another training."""
    device: str = "cpu"
    """Where torch computes: `cpu`, `cuda`, `cuda:1`."""
    episode_steps: int | None = None
    """Decisions of a training episode at most; None is 30 for `reach_target` and 50 for others."""
    leg_steps: int = LEG
    """Decisions between two check points; PPO learns once in each leg. Rounded down to a multiple of the environments."""
    validate_every: int = 2
    """Legs between two looks at how well the most likely action does."""
    validation_episodes: int = 20
    """Episodes of each look, always the same, which training does not meet."""

    def __post_init__(self) -> None:
        """Check every number."""
        if self.algorithm not in ALGORITHMS:
            raise UnknownName("algorithm", str(self.algorithm), ALGORITHMS)
        for name in ("steps", "workers", "leg_steps", "imitation_steps", "validate_every", "validation_episodes"):
            as_whole(getattr(self, name), name, InvalidArgument, least=1)
        as_whole(self.demonstrations, "demonstrations", InvalidArgument, least=0)
        as_flag(self.shaped, "shaped", InvalidArgument)
        as_seed(self.seed, "seed", InvalidArgument)
        if self.leg_steps < LEAST_LEG * self.workers:
            hint = f"has to be at least {LEAST_LEG} for each of the {self.workers} environments"
            raise InvalidArgument("leg_steps", self.leg_steps, hint)
        if self.episode_steps is None:
            object.__setattr__(self, "episode_steps", EPISODE_STEPS.get(self.task, LONG_EPISODE))
        as_whole(self.episode_steps, "episode_steps", InvalidArgument, least=1)

    @property
    def longest(self) -> int:
        """Decisions of a training episode at most."""
        assert self.episode_steps is not None
        return self.episode_steps

    @property
    def leg(self) -> int:
        """Steps between two check points, a multiple of the environments."""
        return self.leg_steps // self.workers * self.workers

    @property
    def legs(self) -> int:
        """How many legs there are."""
        return -(-self.steps // self.leg)

    def identity(self) -> dict[str, Any]:
        """Return what must be the same for a training to go on: all but its length, its device and how it is watched."""
        names = (
            "algorithm",
            "task",
            "shaped",
            "demonstrations",
            "imitation_steps",
            "seed",
            "workers",
            "leg_steps",
            "episode_steps",
        )
        return {name: getattr(self, name) for name in names}
