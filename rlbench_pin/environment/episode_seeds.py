"""What an episode draws: its variation, and one seed spawned by purpose, so that a new draw in one place shifts no other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class EpisodeRandom:
    """The five generators of one episode."""

    variation: np.random.Generator
    """Variation of the task, where none is set."""
    placement: np.random.Generator
    """Where things stand, and what else a task draws."""
    planning: np.random.Generator
    """Starts of inverse kinematics and samples of the planner."""
    noise: np.random.Generator
    """Noise of observations."""
    look: np.random.Generator
    """Domain randomisation."""

    @classmethod
    def from_seed(cls, seed: int, attempt: int = 0) -> EpisodeRandom:
        """Spawn the generators of try `attempt` of episode `seed`; attempt 0 is the seed alone."""
        sequence = np.random.SeedSequence(seed) if attempt == 0 else np.random.SeedSequence((seed, attempt))
        return cls(*(np.random.default_rng(child) for child in sequence.spawn(5)))


def drawn_variations(count: int, most: int) -> tuple[int, ...]:
    """Return all of `count` variations, or `most` of them drawn without repeats, always the same; -1 is all."""
    if most < 0 or count <= most:
        return tuple(range(count))
    return tuple(sorted(np.random.default_rng(0).permutation(count)[:most].tolist()))
