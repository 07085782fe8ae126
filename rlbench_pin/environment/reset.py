"""The steps of a reset: clean state, variation, placement, feasibility, settled world."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rlbench_pin.environment.demos import MAX_ROUNDS
from rlbench_pin.environment.episode import EpisodeRandom
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.waypoint_planning import check_feasible
from rlbench_pin.errors import BoundaryError, PlanningError, ResetError, WaypointError
from rlbench_pin.sim import World
from rlbench_pin.tasks import at_rest

MAX_RESET_ATTEMPTS = 40
"""Maximum number of placements of a reset."""
MAX_PLACES = 100
"""Maximum number of random poses of the task until one is accepted."""
Accept = Callable[[World], bool]
"""Predicate that accepts or rejects the pose of a task."""
SETTLE_TICKS, REST_TICKS = 10, 2
"""Maximum number of control ticks in which a placed task settles, and number of successive ticks at rest that end it."""


@dataclass(frozen=True)
class EpisodeStart:
    """Start of an episode."""

    instructions: tuple[str, ...]
    """Instructions of the episode."""
    attempts: int
    """Number of placement attempts."""


def start_episode(
    runtime: Runtime,
    variation: int,
    random: EpisodeRandom,
    *,
    static: bool,
    max_attempts: int = MAX_RESET_ATTEMPTS,
    accept: Accept | None = None,
) -> EpisodeStart:
    """Set up the start of an episode, after `runtime.build_again`.

    Args:
        runtime: The running task.
        variation: Variation of the task.
        random: Generators of this episode.
        static: Keep the task at the pose of its scene file.
        max_attempts: Maximum number of placements.
        accept: Predicate that accepts or rejects the pose of the task; None accepts all.

    Raises:
        ResetError: No placement has reachable waypoints; the error has the cause of each failure.
    """
    causes: list[str] = []
    for attempt in range(1, max_attempts + 1):
        try:
            instructions = _try_start(runtime, variation, random, static, accept)
        except (BoundaryError, WaypointError, PlanningError) as error:
            causes.append(f"{type(error).__name__}: {error}")
            continue
        return EpisodeStart(tuple(instructions), attempt)
    runtime.world.restore(runtime.world.origin)
    raise ResetError(runtime.task.get_name(), causes)


def lay_out(runtime: Runtime, variation: int, random: EpisodeRandom, *, static: bool, accept: Accept | None = None) -> list[str]:
    """Set up one random episode of a variation without a reachability check, and return its instructions.

    Args:
        runtime: The running task.
        variation: Variation of the task.
        random: Generators of this episode.
        static: Keep the task at the pose of its scene file.
        accept: Predicate that accepts or rejects the pose of the task; None accepts all.

    Raises:
        BoundaryError: An object or the task has no collision-free pose.
    """
    task = runtime.task
    task.end_episode()
    runtime.world.restore(runtime.world.origin)
    runtime.begin(variation, random.planning, random.noise)
    instructions = task.begin_episode(variation, random.placement)
    runtime.instruct(instructions)
    if not static and not task.is_static_workspace():
        _place(runtime, random, accept)
    return instructions


def _place(runtime: Runtime, random: EpisodeRandom, accept: Accept | None) -> None:
    for _ in range(MAX_PLACES):
        runtime.place_task(random.placement)
        if accept is None or accept(runtime.world):
            return
    raise BoundaryError(f"none of {MAX_PLACES} random poses of the task was accepted")


def check_arm_is_free(runtime: Runtime) -> None:
    """Raise BoundaryError if the arm at home touches a body."""
    runtime.refresh_planner()
    pairs = runtime.planner.collision.colliding_pairs(np.array(runtime.description.home))
    if pairs:
        raise BoundaryError(f"the arm at home touches {pairs[0][1]}")


def _try_start(runtime: Runtime, variation: int, random: EpisodeRandom, static: bool, accept: Accept | None) -> list[str]:
    instructions = lay_out(runtime, variation, random, static=static, accept=accept)
    check_arm_is_free(runtime)
    waypoints = runtime.task.get_waypoints()
    if waypoints and runtime.task.repeats_waypoints:
        _check_rounds(runtime, random)
    elif waypoints:
        check_feasible(runtime.planner, waypoints, np.array(runtime.description.home), random.planning)
    come_to_rest(runtime.world)
    runtime.task.reset_conditions()
    return instructions


def come_to_rest(world: World) -> None:
    """Step the world until all bodies that the arm does not hold are at rest, at most `SETTLE_TICKS`."""
    resting = 0
    for _ in range(SETTLE_TICKS):
        world.step()
        resting = resting + 1 if at_rest(world.bodies.values()) else 0
        if resting == REST_TICKS:
            return


def _check_rounds(runtime: Runtime, random: EpisodeRandom) -> None:
    """Raise WaypointError unless the waypoints of all rounds that can be predicted are reachable.

    The start hooks set the waypoints as in a demonstration. A round with the same poses as the previous one depends on
    later events, so it is the last round that is checked.
    """
    task = runtime.task
    state, poses = runtime.save(), b""
    try:
        for _ in range(MAX_ROUNDS):
            waypoints = task.get_waypoints()
            for waypoint in waypoints:
                waypoint.run_start_hook()
            before, poses = poses, b"".join(waypoint.pose.tobytes() for waypoint in waypoints)
            if poses == before:
                return
            check_feasible(runtime.planner, waypoints, np.array(runtime.description.home), random.planning)
            if not task.should_repeat_waypoints():
                return
    finally:
        runtime.restore(state)
