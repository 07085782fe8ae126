"""The path of a reset: clean state -> variation -> placement -> feasibility -> settled world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.environment.randomness import EpisodeRandom
from rlbench_pin.environment.scene import Scene
from rlbench_pin.environment.turns import check_feasible
from rlbench_pin.errors import BoundaryError, PlanningError, ResetError, WaypointError
from rlbench_pin.tasks import place_task

MAX_RESET_ATTEMPTS = 40
SETTLE_TICKS = 10
_MAX_ROUNDS = 10


@dataclass(frozen=True)
class EpisodeStart:
    """How an episode began."""

    instructions: tuple[str, ...]
    attempts: int
    """Placement attempts that were needed."""


def start_episode(
    scene: Scene,
    variation: int,
    random: EpisodeRandom,
    *,
    static: bool,
    max_attempts: int = MAX_RESET_ATTEMPTS,
) -> EpisodeStart:
    """Bring the scene to the start of an episode.

    Args:
        scene: The running scene.
        variation: Variation of the task.
        random: Generators of this episode.
        static: Leave the task where its scene file puts it.
        max_attempts: Placements to try.

    Raises:
        ResetError: No attempt gave a placement whose waypoints can all be reached; carries why each failed.
    """
    causes: list[str] = []
    scene.task.end_episode()
    scene.world.build_again()
    for attempt in range(1, max_attempts + 1):
        try:
            instructions = _try_start(scene, variation, random, static)
        except (BoundaryError, WaypointError, PlanningError) as error:
            causes.append(f"{type(error).__name__}: {error}")
            continue
        return EpisodeStart(tuple(instructions), attempt)
    scene.world.restore(scene.world.origin)
    raise ResetError(scene.task.get_name(), causes)


def lay_out(scene: Scene, variation: int, random: EpisodeRandom, *, static: bool) -> list[str]:
    """Put one draw of a variation on the table, whether it can be reached or not, and return its instructions.

    Args:
        scene: The running scene.
        variation: Variation of the task.
        random: Generators of this episode.
        static: Leave the task where its scene file puts it.

    Raises:
        BoundaryError: Something found no place.
    """
    task = scene.task
    task.end_episode()
    scene.world.restore(scene.world.origin)
    scene.variation = variation
    scene.planning_rng, scene.noise_rng = random.planning, random.noise
    instructions = task.begin_episode(variation, random.placement)
    if not static and not task.is_static_workspace():
        place_task(scene.world, random.placement, task.base_rotation_bounds())
    return instructions


def check_arm_is_free(scene: Scene) -> None:
    """Raise BoundaryError when the arm at home touches something."""
    scene.refresh_planner()
    pairs = scene.planner.collision.colliding_pairs(np.array(scene.description.home))
    if pairs:
        raise BoundaryError(f"the arm at home touches {pairs[0][1]}")


def _try_start(scene: Scene, variation: int, random: EpisodeRandom, static: bool) -> list[str]:
    instructions = lay_out(scene, variation, random, static=static)
    check_arm_is_free(scene)
    waypoints = scene.task.get_waypoints()
    if waypoints:
        check_feasible(scene.planner, waypoints, np.array(scene.description.home), random.planning)
        _check_later_rounds(scene, random)
    for _ in range(SETTLE_TICKS):
        scene.world.step()
    scene.task.reset_conditions()
    return instructions


def _check_later_rounds(scene: Scene, random: EpisodeRandom) -> None:
    """Raise WaypointError unless the waypoints of every round can be reached, as far as the rounds are known beforehand.

    The start hooks aim as in a demonstration. A round that asks for the same poses as the one before waits for something to
    happen, and is the last one that is looked at.
    """
    task = scene.task
    if not task.repeats_waypoints:
        return
    state, poses = scene.save(), b""
    try:
        for _ in range(_MAX_ROUNDS):
            waypoints = task.get_waypoints()
            for waypoint in waypoints:
                waypoint.run_start_hook()
            before, poses = poses, b"".join(waypoint.pose.tobytes() for waypoint in waypoints)
            if poses == before:
                return
            check_feasible(scene.planner, waypoints, np.array(scene.description.home), random.planning)
            if not task.should_repeat_waypoints():
                return
    finally:
        scene.restore(state)
