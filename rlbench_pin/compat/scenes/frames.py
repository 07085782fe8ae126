"""Demonstrations with other frames, or of frames alone."""

from __future__ import annotations

from collections.abc import Sequence

from rlbench_pin.environment.episode import EpisodeOrigin
from rlbench_pin.observation import Demo, Observation


def with_frames(demo: Demo, frames: Sequence[Observation]) -> Demo:
    """Return `demo` with `frames` in place of its own."""
    return Demo(
        frames,
        random_seed=demo.random_seed,
        num_reset_attempts=demo.num_reset_attempts,
        variation_number=demo.variation_number,
        instructions=demo.instructions,
        state=demo.state,
        versions=demo.versions,
        attempt=demo.attempt,
        task_name=demo.task_name,
    )


def sign(demo: Demo, origin: EpisodeOrigin, task_name: str, variation: int) -> None:
    """Write into a demonstration how its episode began, so that it can be started from again.

    Args:
        demo: Made of observations alone.
        origin: Where the episode came from.
        task_name: Name of the task.
        variation: Variation of the task.
    """
    demo.random_seed, demo.attempt, demo.num_reset_attempts = origin.seed, origin.attempt, origin.reset_attempts
    demo.instructions, demo.task_name, demo.variation_number = origin.instructions, task_name, variation
