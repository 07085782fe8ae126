"""What the loop knows of the present episode, and of a moment to go back to."""

from __future__ import annotations

from dataclasses import dataclass

from rlbench_pin.environment.randomization.sample import RandomizationSample
from rlbench_pin.environment.runtime import RuntimeState


@dataclass(frozen=True)
class EpisodeOrigin:
    """Where an episode came from."""

    seed: int
    attempt: int
    """Which try of the seed."""
    reset_attempts: int
    """Placements that the reset needed."""
    instructions: tuple[str, ...]
    """What is asked for, in sentences that mean the same."""


@dataclass(frozen=True)
class EnvironmentState:
    """A moment of an episode, to go back to."""

    runtime: RuntimeState
    episode: EpisodeOrigin
    randomization: RandomizationSample | None = None
    """What domain randomization has made of the scene."""
