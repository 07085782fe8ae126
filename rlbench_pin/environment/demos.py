"""Live demonstrations: one try, tries until one succeeds, and what becomes a `Demo`, with the versions that made it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from rlbench_pin.environment.demonstrate import DemoOutcome, DemoPlayer, try_play
from rlbench_pin.environment.episode import EpisodeOrigin, checked_seed
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import DemoError, InvalidArgument, TaskEnvironmentError
from rlbench_pin.observation import Demo, Observation, RandomState
from rlbench_pin.tasks import Task
from rlbench_pin.values import as_record

LIBRARIES = ("rlbench_pin", "pin", "coal", "pybullet", "ompl", "toppra", "placo", "osqp", "numpy")
"""Distributions that shape a demonstration."""


class LiveDemoFailed(DemoError, RuntimeError):
    """A live demonstration failed at every attempt; carries why."""

    def __init__(self, task_name: str, seed: int, causes: list[str], task: object) -> None:
        self.seed, self.causes = seed, tuple(causes)
        text = "; ".join(f"attempt {i}: {cause}" for i, cause in enumerate(causes))
        super().__init__(
            f"Task '{task_name}' could not be demonstrated from seed {seed} in {len(causes)} attempts ({text}). "
            f"`rlbench-pin check {task_name}` shows how often that happens.",
            task,
        )


def play_demo(
    runtime: Runtime,
    origin: EpisodeOrigin,
    *,
    record: bool,
    record_gripper: bool,
    on_frame: Callable[[Observation], None] | None,
) -> DemoOutcome:
    """Play the demonstration of the episode that has just started, whatever comes of it.

    Args:
        runtime: The runtime, at the start of the episode.
        origin: Where the episode came from.
        record: Keep observations; False only measures.
        record_gripper: Keep those of finger motions, too.
        on_frame: Called with every recorded observation.
    """
    state, began = runtime.world.arrays(exact=False), runtime.world.time
    player = DemoPlayer(runtime, record=record, record_gripper=record_gripper, on_frame=on_frame)
    cause, leg = try_play(player)
    demo = None if cause else _as_demo(runtime, origin, player.frames, state)
    duration = runtime.world.time - began
    return DemoOutcome(not cause, cause, leg, demo, player.planning_time, duration, tuple(player.legs))


def _as_demo(runtime: Runtime, origin: EpisodeOrigin, frames: list[Observation], state: dict[str, np.ndarray]) -> Demo:
    return Demo(
        frames,
        random_seed=origin.seed,
        num_reset_attempts=origin.reset_attempts,
        variation_number=runtime.variation,
        instructions=origin.instructions,
        state=state,
        versions=library_versions(),
        attempt=origin.attempt,
        task_name=runtime.task.get_name(),
    )


def live_demos(play: Callable[[int, int], DemoOutcome], task: Task, seeds: Iterable[int], max_attempts: int) -> list[Demo]:
    """Return a demonstration for each seed.

    Args:
        play: Plays one try of a seed, given the seed and the number of the try.
        task: The task that is shown.
        seeds: Seeds of the episodes.
        max_attempts: Tries per seed.

    Raises:
        LiveDemoFailed: A seed failed at every try.
        TaskEnvironmentError: `max_attempts` is below 1.
    """
    if max_attempts < 1:
        raise TaskEnvironmentError(f"max_attempts={max_attempts} tries nothing; it must be at least 1.")
    return [_live_demo(play, task, seed, max_attempts) for seed in seeds]


def _live_demo(play: Callable[[int, int], DemoOutcome], task: Task, seed: int, max_attempts: int) -> Demo:
    causes: list[str] = []
    for attempt in range(max_attempts):
        outcome = play(seed, attempt)
        if outcome.demo is not None:
            return outcome.demo
        causes.append(outcome.cause)
    raise LiveDemoFailed(task.get_name(), seed, causes, task)


def check_start(demo: Demo, task_name: str) -> int:
    """Return the seed of a demonstration, from which its task is set up.

    Where it carries the state of a generator instead, its snapshot says where everything is, and the seed is a hash of the state.

    Raises:
        TaskEnvironmentError: It is of another task than `task_name`, or carries no seed, or a state without a snapshot.
    """
    as_record(demo, Demo, "demo", InvalidArgument)
    if demo.task_name and demo.task_name != task_name:
        raise TaskEnvironmentError(f"The demonstration shows '{demo.task_name}', this is '{task_name}'.")
    if demo.random_seed is None:
        raise TaskEnvironmentError("The demonstration carries no seed, so its start cannot be restored. Record it again.")
    if not isinstance(demo.random_seed, tuple):
        return checked_seed(demo.random_seed)
    if demo.state is None:
        raise TaskEnvironmentError(
            "The demonstration carries the state of a random number generator instead of a seed, and no snapshot of the world: "
            "its start cannot be restored. Record it again."
        )
    return _seed_from(demo.random_seed)


def _seed_from(state: RandomState) -> int:
    """Return a seed that stands for the state of a generator: a hash of it."""
    parts = b"".join(part.tobytes() if isinstance(part, np.ndarray) else repr(part).encode() for part in state)
    return int.from_bytes(hashlib.sha256(parts).digest()[:6], "big")


def restore_start(runtime: Runtime, demo: Demo) -> None:
    """Bring the world to the exact state that a demonstration started from, where its seed alone did not."""
    if demo.state is not None and not _same_arrays(runtime.world.arrays(exact=False), demo.state):
        runtime.world.set_arrays(demo.state)
        runtime.task.reset_conditions()


def _same_arrays(a: Mapping[str, np.ndarray], b: Mapping[str, np.ndarray]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(a[k], b[k]) for k in a)


def library_versions() -> dict[str, str]:
    """Return name -> version of this package and the libraries that shape a demonstration; `unknown` without metadata."""
    return {name: _version(name) for name in LIBRARIES}


def _version(name: str) -> str:
    try:
        return version(name.replace("_", "-"))
    except PackageNotFoundError:  # a source tree that was never installed
        return "unknown"
