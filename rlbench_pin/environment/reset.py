"""The path of a reset: clean state -> variation -> placement -> feasibility -> settled world."""

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
"""Placements that a reset tries."""
MAX_PLACES = 100
"""Places of the task that are drawn until one is accepted."""
Accept = Callable[[World], bool]
"""Whether the place of a task will do."""
SETTLE_TICKS, REST_TICKS = 10, 2
"""Control ticks that a placed task comes to rest in at most, and how many of them in a row it has to rest to be left at that."""


@dataclass(frozen=True)
class EpisodeStart:
    """How an episode began."""

    instructions: tuple[str, ...]
    """Sentences that say what to do."""
    attempts: int
    """Placement attempts that were needed."""


def start_episode(
    runtime: Runtime,
    variation: int,
    random: EpisodeRandom,
    *,
    static: bool,
    max_attempts: int = MAX_RESET_ATTEMPTS,
    accept: Accept | None = None,
) -> EpisodeStart:
    """Bring the task to the start of an episode.

    Args:
        runtime: The running task.
        variation: Variation of the task.
        random: Generators of this episode.
        static: Leave the task where its scene file puts it.
        max_attempts: Placements to try.
        accept: Whether a place of the task will do; None takes any.

    Raises:
        ResetError: No attempt gave a placement whose waypoints can all be reached; carries why each failed.
    """
    causes: list[str] = []
    runtime.task.end_episode()
    runtime.world.build_again()
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
    """Lay out one random episode of a variation, whether it can be reached or not, and return its instructions.

    Args:
        runtime: The running task.
        variation: Variation of the task.
        random: Generators of this episode.
        static: Leave the task where its scene file puts it.
        accept: Whether a place of the task will do; None takes any.

    Raises:
        BoundaryError: Something found no place.
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
    raise BoundaryError(f"none of {MAX_PLACES} places of the task was accepted")


def check_arm_is_free(runtime: Runtime) -> None:
    """Raise BoundaryError when the arm at home touches something."""
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
    """Step the world until nothing moves that is not held by the arm, `SETTLE_TICKS` at most."""
    resting = 0
    for _ in range(SETTLE_TICKS):
        world.step()
        resting = resting + 1 if at_rest(world.bodies.values()) else 0
        if resting == REST_TICKS:
            return


def _check_rounds(runtime: Runtime, random: EpisodeRandom) -> None:
    """Raise WaypointError unless the waypoints of every round can be reached, as far as the rounds are known beforehand.

    The start hooks aim as in a demonstration. A round that asks for the same poses as the one before waits for something to
    happen, and is the last one that is looked at.
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
