"""Symmetric grasps: which turn of the hand about its own z makes a chain of waypoints easiest.

A run is a stretch of waypoints that must share one turn: same symmetry, ended by letting go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.errors import NoIkSolution, NotStraight, WaypointError
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.planning.straight import curve_path, straight_path
from rlbench_pin.spatial import FloatArray, compose
from rlbench_pin.tasks import Waypoint

_BROKEN_LINE = 10.0
"""Cost of a line that cannot be followed from where the leg before it would end: another turn of the hand is better [rad]."""


@dataclass(frozen=True, eq=False)
class RunChoice:
    """One feasible turn of a run."""

    turn: float
    """Angle about the hand's z [rad]."""
    cost: float
    """Joint distance travelled over the run [rad]."""
    q_end: FloatArray
    """Configuration at the end of the run."""


def turned(pose: FloatArray, turn: float) -> FloatArray:
    """Rotate a tip pose about its own z by `turn` [rad]."""
    if turn == 0.0:
        return pose
    return compose(pose, [0.0, 0.0, 0.0, 0.0, 0.0, np.sin(turn / 2.0), np.cos(turn / 2.0)])


def runs(waypoints: Sequence[Waypoint]) -> list[list[Waypoint]]:
    """Cut a waypoint list into runs."""
    result: list[list[Waypoint]] = []
    for waypoint in waypoints:
        new = not result or result[-1][-1].lets_go or result[-1][-1].symmetry != waypoint.symmetry
        if new:
            result.append([])
        result[-1].append(waypoint)
    return result


def poses_of(waypoint: Waypoint, turn: float, previous: FloatArray) -> list[FloatArray]:
    """Tip poses that a waypoint asks to pass, turned; the last is where it ends."""
    if waypoint.path == "curve":
        return [turned(pose, turn) for pose in waypoint.curve_poses(turned(previous, -turn))]
    return [turned(waypoint.pose, turn)]


def _try_turn(
    planner: MotionPlanner, run: Sequence[Waypoint], turn: float, q: FloatArray, previous: FloatArray, rng: np.random.Generator
) -> RunChoice:
    cost = 0.0
    for waypoint in run:
        poses = poses_of(waypoint, turn, previous)
        previous = poses[-1]
        line = _line_end(planner, waypoint, poses, q)
        if line is not None:
            cost += float(np.abs(line - q).max())
            q = line
            continue
        cost += 0.0 if waypoint.path == "plan" else _BROKEN_LINE
        for pose in poses[:: max(1, len(poses) // 4)] if len(poses) > 1 else poses:
            q_next = planner.reachable(q, pose, rng)
            cost += float(np.abs(q_next - q).max())
            q = q_next
    return RunChoice(turn, cost, q)


def _line_end(planner: MotionPlanner, waypoint: Waypoint, poses: Sequence[FloatArray], q: FloatArray) -> FloatArray | None:
    """Return where a line or a curve that has to be followed ends (n,); None when there is none or it cannot be followed."""
    try:
        if waypoint.path == "curve":
            return np.array(curve_path(planner.model, q, poses)[-1])
        return np.array(straight_path(planner.model, q, poses[-1])[-1]) if waypoint.path == "straight" else None
    except NotStraight:
        return None


def rank_turns(
    planner: MotionPlanner, run: Sequence[Waypoint], q: FloatArray, previous: FloatArray, rng: np.random.Generator
) -> list[RunChoice]:
    """Return the feasible turns of a run, least joint travel first.

    Args:
        planner: Planner used for inverse kinematics, collisions ignored.
        run: Waypoints that share one turn.
        q: Configuration before the run, shape (n,), [rad].
        previous: Tip pose before the run, shape (7,).
        rng: Source of inverse-kinematics starts.

    Raises:
        WaypointError: No turn reaches every waypoint of the run.
    """
    symmetry = run[0].symmetry
    choices: list[RunChoice] = []
    cause: NoIkSolution | None = None
    for k in range(symmetry):
        turn = 2.0 * np.pi * k / symmetry
        try:
            choices.append(_try_turn(planner, run, turn if turn <= np.pi else turn - 2.0 * np.pi, q, previous, rng))
        except NoIkSolution as error:
            cause = error
    if not choices:
        span = f"{run[0].index} to {run[-1].index}"
        raise WaypointError(f"Waypoints {span} cannot be reached one after the other: {cause}") from cause
    return sorted(choices, key=lambda choice: choice.cost)


def check_feasible(planner: MotionPlanner, waypoints: Sequence[Waypoint], q: FloatArray, rng: np.random.Generator) -> None:
    """Raise WaypointError unless every waypoint can be reached in sequence, collisions ignored."""
    previous = planner.model.tip_pose(q)
    for run in runs([w for w in waypoints if not w.skip]):
        best = rank_turns(planner, run, q, previous, rng)[0]
        q, previous = best.q_end, planner.model.tip_pose(best.q_end)
