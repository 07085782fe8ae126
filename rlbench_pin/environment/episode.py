"""An episode: the generators that set it up, where it came from, and moments of it to go back to.

One seed per episode is spawned by purpose, so that a new draw in one place shifts no other.
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
"""Seeds of evaluations begin here. Resets without a seed draw theirs below 2^31, recordings make theirs below 2^53."""
MAX_DEMOS = 10_000_000
"""Live demonstrations of one call at most."""


@dataclass(frozen=True)
class EpisodeRandom:
    """The generators of one episode."""

    variation: np.random.Generator
    """Variation of the task, where none is set."""
    placement: np.random.Generator
    """Poses of objects, and all else that a task draws."""
    planning: np.random.Generator
    """Starts of inverse kinematics and samples of the planner."""
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
    """Which try of the seed."""
    reset_attempts: int
    """Placements that the reset needed."""
    instructions: tuple[str, ...]
    """Instructions of the episode; all mean the same."""
    factors: str = ""
    """Factors of generalisation and their levels, such as `light_color:2`; empty without."""


@dataclass(frozen=True)
class EnvironmentState:
    """A moment of an episode, to go back to. It can be pickled, and then used by an environment of the same task and settings."""

    runtime: RuntimeState
    episode: EpisodeOrigin
    randomization: RandomizationSample | None = None
    """Changes of domain randomization in the world."""

    def unpickled_variation(self, task: str) -> int | None:
        """Return the variation of a state that was pickled, None of one that was not.

        Args:
            task: Name of the task that is to take it over.

        Raises:
            TaskEnvironmentError: The state is of another task.
        """
        kept = self.runtime.task
        if not isinstance(kept, PortableTaskState):
            return None
        if kept.task != task:
            raise TaskEnvironmentError(f"The state is of task '{kept.task}', this is '{task}'. Load that task with `get_task`.")
        return self.runtime.variation


def checked_seed(seed: object) -> int:
    """Return `seed` as an int.

    Raises:
        InvalidArgument: It is not a whole number, or not between 0 and 2^63 - 1 (also a TaskEnvironmentError and a ValueError).
    """
    return as_seed(seed, "A seed", InvalidArgument)


def demo_seeds(amount: int, seed: int | None, rng: np.random.Generator) -> list[int]:
    """Return the seeds of `amount` live demonstrations: counted from `seed`, or drawn when it is None.

    Raises:
        InvalidArgument: `amount` is less than 1, or the seed is not a whole number >= 0, or one of the others would be too large.
    """
    amount = as_whole(amount, "The amount of live demonstrations", InvalidArgument, least=1, most=MAX_DEMOS)
    if seed is None:
        return [int(s) for s in rng.integers(2**31, size=amount)]
    first = checked_seed(seed)
    checked_seed(first + amount - 1)
    return list(range(first, first + amount))


def drawn_variations(count: int, most: int) -> tuple[int, ...]:
    """Return all of `count` variations, or `most` of them drawn without repeats, always the same; -1 is all."""
    if most < 0 or count <= most:
        return tuple(range(count))
    return tuple(sorted(np.random.default_rng(0).permutation(count)[:most].tolist()))
