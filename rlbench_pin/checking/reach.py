"""Reachability of the waypoints, over all placements of a task."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.environment.episode import EpisodeRandom
from rlbench_pin.environment.reset import check_arm_is_free, lay_out
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.waypoint_planning import grasp_groups, poses_of
from rlbench_pin.errors import BoundaryError, NoIkSolution
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.spatial import FloatArray, pose_to_se3
from rlbench_pin.tasks import Waypoint


@dataclass(frozen=True)
class Reach:
    """Reachability in one random layout of the task; layouts that a reset would reject are included."""

    place: tuple[float, float, float]
    """x, y [m] and yaw [rad] of the task root."""
    waypoints: tuple[int, ...]
    reached: tuple[bool, ...]
    """Whether the arm reaches each waypoint after the previous ones, collisions ignored, as a reset requires."""
    spots: tuple[tuple[float, float], ...]
    """x, y of each waypoint [m]."""
    free: bool
    """Whether the arm in its home configuration touches nothing."""

    @property
    def accepted(self) -> bool:
        """Whether a reset would accept this layout."""
        return self.free and all(self.reached)


def reach_of(runtime: Runtime, seed: int, variation: int) -> Reach:
    """Set up the layout of the task for a seed, and check which waypoints can be reached.

    Raises:
        BoundaryError: An object could not be placed.
    """
    random = EpisodeRandom.from_seed(seed)
    runtime.build_again()
    lay_out(runtime, variation, random, static=False)
    root = pose_to_se3(runtime.world.root.pose)
    yaw = float(np.arctan2(root.rotation[1, 0], root.rotation[0, 0]))
    waypoints = runtime.task.get_waypoints()
    spots = tuple((float(w.pose[0]), float(w.pose[1])) for w in waypoints)
    reached = _reached(runtime.planner, waypoints, np.array(runtime.description.home), random.planning)
    place = (float(root.translation[0]), float(root.translation[1]), yaw)
    return Reach(place, tuple(w.index for w in waypoints), reached, spots, _arm_is_free(runtime))


def _arm_is_free(runtime: Runtime) -> bool:
    try:
        check_arm_is_free(runtime)
    except BoundaryError:
        return False
    return True


def _reached(planner: MotionPlanner, waypoints: Sequence[Waypoint], q: FloatArray, rng: np.random.Generator) -> tuple[bool, ...]:
    """Return which waypoints are reached in order; each group has the grasp symmetry that reaches most of its waypoints."""
    found: list[bool] = []
    previous = planner.model.tip_pose(q)
    for run in grasp_groups(waypoints):
        tries = [_visit(planner, run, 2.0 * np.pi * k / run[0].symmetry, q, previous, rng) for k in range(run[0].symmetry)]
        reached, _, q = max(tries, key=lambda tried: (sum(tried[0]), -tried[1]))
        previous = planner.model.tip_pose(q)
        found += reached
    return tuple(found)


def _visit(
    planner: MotionPlanner, run: Sequence[Waypoint], turn: float, q: FloatArray, previous: FloatArray, rng: np.random.Generator
) -> tuple[list[bool], float, FloatArray]:
    """Return which waypoints of a group are reached, the joint motion [rad], and the final configuration (n,) [rad]."""
    reached, travel = [], 0.0
    for waypoint in run:
        poses = poses_of(waypoint, turn if turn <= np.pi else turn - 2.0 * np.pi, previous)
        previous = poses[-1]
        try:
            for pose in poses[:: max(1, len(poses) // 4)] if len(poses) > 1 else poses:
                q_next = planner.reachable(q, pose, rng)
                travel += float(np.abs(q_next - q).max())
                q = q_next
        except NoIkSolution:
            reached.append(False)
            continue
        reached.append(True)
    return reached, travel, q
