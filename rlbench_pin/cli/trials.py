"""What `rlbench-pin check` asks of a task, as work items that any process can do and that do not depend on each other."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from rlbench_pin.cli.setup import find_task, low_dim_config, make_environment
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.errors import ResetError
from rlbench_pin.observation import Demo

IDLE_STEPS = RANDOM_STEPS = 200
EXTRA_STEPS = 10
"""Repetitions of the last action when a replay has not succeeded yet, as many as a demonstration waits."""

ENGINE_STATE = "physics"
"""Array of `World.arrays` that holds the engine's own file, in which memory addresses differ from save to save."""

Part = Literal["demos", "idle", "random", "repeat"]


@dataclass(frozen=True)
class Item:
    """A piece of work: some seeds of one part of the check of one task."""

    task: str
    """Name, or path of a task file."""
    part: Part
    seeds: tuple[int, ...]
    max_variations: int
    max_attempts: int = 10
    first_seed: int = 0


@dataclass(frozen=True)
class Trial:
    """What one seed showed."""

    task: str
    part: Part
    seed: int
    variation: int
    success: bool
    """demos: within the tries; idle and random: the goal was reached (it should not be); repeat: the reset repeats exactly."""
    tries: int = 1
    causes: tuple[str, ...] = ()
    """Why each failed try failed."""
    legs: tuple[int | None, ...] = ()
    """Waypoint at which each failed try failed."""
    replayed: bool | None = None
    """Whether the recorded joint-position actions succeed again."""
    frames: int = 0
    simulated: float = 0.0
    """Length of the demonstration [s]."""
    planning: float = 0.0
    """Time spent planning it [s]."""
    wall: float = 0.0
    """Time that reset and demonstration took [s]."""


def drawn_variations(count: int, maximum: int) -> tuple[int, ...]:
    """Return all variations, or `maximum` of them drawn without repeats, always the same."""
    if count <= maximum:
        return tuple(range(count))
    return tuple(sorted(np.random.default_rng(0).permutation(count)[:maximum].tolist()))


def work(item: Item) -> list[Trial]:
    """Do one item in an environment of its own."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task(find_task(item.task))
        variations = drawn_variations(task.variation_count(), item.max_variations)
        return [_trial(task, item, seed, variations[(seed - item.first_seed) % len(variations)]) for seed in item.seeds]


def _trial(task: TaskEnvironment, item: Item, seed: int, variation: int) -> Trial:
    try:
        if item.part == "demos":
            return demo_trial(task, seed, variation, item.max_attempts)
        success = {"idle": idle_succeeds, "random": random_succeeds, "repeat": reset_repeats}[item.part](task, seed, variation)
        return Trial(task.get_name(), item.part, seed, variation, success)
    except ResetError as error:
        return Trial(task.get_name(), item.part, seed, variation, False, 0, (f"reset: {error}",), (None,))


def demo_trial(task: TaskEnvironment, seed: int, variation: int, max_attempts: int) -> Trial:
    """Try to demonstrate one seed, then replay the recorded actions."""
    causes: list[str] = []
    legs: list[int | None] = []
    for attempt in range(max_attempts):
        began = time.perf_counter()
        outcome = task.try_demo(seed=seed, variation=variation, attempt=attempt)
        wall = time.perf_counter() - began
        if outcome.demo is not None:
            return Trial(
                task.get_name(), "demos", seed, variation, True, attempt + 1, tuple(causes), tuple(legs),
                replayed=replay_succeeds(task, outcome.demo), frames=len(outcome.demo),
                simulated=outcome.duration, planning=outcome.planning_time, wall=wall,
            )  # fmt: skip
        causes.append(outcome.cause)
        legs.append(outcome.leg)
    return Trial(task.get_name(), "demos", seed, variation, False, max_attempts, tuple(causes), tuple(legs))


def replay_succeeds(task: TaskEnvironment, demo: Demo) -> bool:
    """Whether the joint-position actions of a demonstration reach the goal through `step`."""
    task.reset_to_demo(demo)
    actions = [obs.misc["joint_position_action"] for obs in demo[1:]]
    return _reaches_goal(task, [*actions, *[actions[-1]] * EXTRA_STEPS])


def idle_succeeds(task: TaskEnvironment, seed: int, variation: int) -> bool:
    """Whether resting reaches the goal; it should not."""
    task.reset(seed=seed, variation=variation)
    return _reaches_goal(task, [np.append(task.world.robot.joint_positions, 1.0)] * IDLE_STEPS)


def random_succeeds(task: TaskEnvironment, seed: int, variation: int) -> bool:
    """Whether actions drawn evenly from the action space reach the goal; they should not."""
    rng = np.random.default_rng(seed)
    task.reset(seed=seed, variation=variation)
    low, high = task.action_bounds()
    for _ in range(RANDOM_STEPS):
        _, reward, _ = task.step(rng.uniform(low, high))
        if reward > 0.0:
            return True
    return False


def reset_repeats(task: TaskEnvironment, seed: int, variation: int) -> bool:
    """Whether the same seed gives the same world, bit for bit, also after another episode."""
    first = _start(task, seed, variation)
    task.reset(seed=seed + 1)
    task.step(np.append(task.world.robot.joint_positions, 0.0))
    return _start(task, seed, variation) == first


def _start(task: TaskEnvironment, seed: int, variation: int) -> bytes:
    """Bytes of the world after a reset and again some steps later, when differences that were hidden have shown."""
    task.reset(seed=seed, variation=variation)
    first = _world_bytes(task)
    for _ in range(EXTRA_STEPS):
        task.step(np.append(task.world.robot.joint_positions, 1.0))
    return first + _world_bytes(task)


def _world_bytes(task: TaskEnvironment) -> bytes:
    arrays = task.world.arrays()
    return b"".join(arrays[name].tobytes() for name in sorted(arrays) if name != ENGINE_STATE)


def _reaches_goal(task: TaskEnvironment, actions: Sequence[np.ndarray]) -> bool:
    for action in actions:
        _, reward, terminate = task.step(action)
        if reward > 0.0 or terminate:
            return reward > 0.0
    return False
