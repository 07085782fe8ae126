"""One seed per episode, spawned by purpose, so that a new draw in one place shifts no other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class EpisodeRandom:
    """The five generators of one episode."""

    variation: np.random.Generator
    placement: np.random.Generator
    planning: np.random.Generator
    noise: np.random.Generator
    randomization: np.random.Generator
    """Domain randomization."""

    @classmethod
    def from_seed(cls, seed: int, attempt: int = 0) -> EpisodeRandom:
        """Spawn the generators of try `attempt` of episode `seed`; attempt 0 is the seed alone."""
        sequence = np.random.SeedSequence(seed) if attempt == 0 else np.random.SeedSequence((seed, attempt))
        return cls(*(np.random.default_rng(child) for child in sequence.spawn(5)))
