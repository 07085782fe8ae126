"""Episodes: their random generators, their origin, and states that can be restored.

One generator per purpose is spawned from the seed, so that a new draw in one place does not change the others.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.environment.randomization.sample import RandomizationSample
from rlbench_pin.environment.runtime import RuntimeState
from rlbench_pin.errors import InvalidArgument, TaskEnvironmentError
from rlbench_pin.tasks.saved.portable_state import PortableTaskState
from rlbench_pin.values import as_seed, as_whole

EVALUATION_SEEDS = 2**53
"""Lowest seed of evaluations. Resets without a seed draw seeds below 2^31; recordings use seeds below 2^53."""
MAX_DEMOS = 10_000_000
"""Maximum number of live demonstrations of one call."""


@dataclass(frozen=True)
class EpisodeRandom:
    """The generators of one episode."""

    variation: np.random.Generator
    """Variation of the task, if none is set."""
    placement: np.random.Generator
    """Poses of objects, and all other draws of a task."""
    planning: np.random.Generator
    """Start configurations of inverse kinematics and samples of the planner."""
    noise: np.random.Generator
    """Noise of observations."""
    randomization: np.random.Generator
    """Domain randomization."""
    disturbance: np.random.Generator
    """Disturbances of recovery demonstrations."""

    @classmethod
    def from_seed(cls, seed: int, attempt: int = 0) -> EpisodeRandom:
        """Spawn the generators of try `attempt` of episode `seed`; attempt 0 is the seed alone."""
        sequence = np.random.SeedSequence(seed) if attempt == 0 else np.random.SeedSequence((seed, attempt))
        return cls(*(np.random.default_rng(child) for child in sequence.spawn(6)))


@dataclass(frozen=True)
class EpisodeOrigin:
    """Origin of an episode."""

    seed: int
    attempt: int
    """Number of the attempt at the seed, from 0."""
    reset_attempts: int
    """Number of placements that the reset needed."""
    instructions: tuple[str, ...]
    """Instructions of the episode; all have the same meaning."""
    factors: str = ""
    """Factors of generalisation and their levels, such as `light_color:2`; empty for none."""


@dataclass(frozen=True)
class EnvironmentState:
    """A state of an episode that can be restored, and pickled for an environment of the same task and settings."""

    runtime: RuntimeState
    episode: EpisodeOrigin
    randomization: RandomizationSample | None = None
    """Changes of the world by domain randomization."""

    def unpickled_variation(self, task: str) -> int | None:
        """Return the variation of a pickled state; None for a state of this process.

        Args:
            task: Name of the task that restores the state.

        Raises:
            TaskEnvironmentError: The state is of another task.
        """
        kept = self.runtime.task
        if not isinstance(kept, PortableTaskState):
            return None
        if kept.task != task:
            raise TaskEnvironmentError(
                f"The state is of task '{kept.task}', but this environment runs '{task}'. Load that task with `get_task`."
            )
        return self.runtime.variation


def checked_seed(seed: object) -> int:
    """Return `seed` as an int.

    Raises:
        InvalidArgument: It is not an integer, or not between 0 and 2^63 - 1 (also a TaskEnvironmentError and a ValueError).
    """
    return as_seed(seed, "A seed", InvalidArgument)


def demo_seeds(amount: int, seed: int | None, rng: np.random.Generator) -> list[int]:
    """Return the seeds of `amount` live demonstrations: consecutive from `seed`, or drawn if it is None.

    Raises:
        InvalidArgument: `amount` is less than 1, the seed is not an integer >= 0, or the last seed is too large.
    """
    amount = as_whole(amount, "amount, the number of live demonstrations,", InvalidArgument, least=1, most=MAX_DEMOS)
    if seed is None:
        return [int(s) for s in rng.integers(2**31, size=amount)]
    first = checked_seed(seed)
    checked_seed(first + amount - 1)
    return list(range(first, first + amount))


def drawn_variations(count: int, most: int) -> tuple[int, ...]:
    """Return all of `count` variations, or a fixed random subset of `most` of them; -1 returns all."""
    if most < 0 or count <= most:
        return tuple(range(count))
    return tuple(sorted(np.random.default_rng(0).permutation(count)[:most].tolist()))
