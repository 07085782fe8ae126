"""A demonstration with other frames."""

from __future__ import annotations

from collections.abc import Sequence

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
