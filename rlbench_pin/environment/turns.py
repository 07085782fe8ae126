"""Symmetric grasps: which turn of the hand about its own z makes a chain of waypoints easiest.

A run is a stretch of waypoints that must share one turn: same symmetry, ended by letting go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

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
        more, q, previous = _visit(planner, waypoint, turn, q, previous, rng)
        cost += more
    return RunChoice(turn, cost, q)


def _visit(
    planner: MotionPlanner, waypoint: Waypoint, turn: float, q: FloatArray, previous: FloatArray, rng: np.random.Generator
) -> tuple[float, FloatArray, FloatArray]:
    """Return what it costs to go on to a waypoint with the hand turned, the configuration there and the last tip pose."""
    poses = poses_of(waypoint, turn, previous)
    line = _line_end(planner, waypoint, poses, q)
    if line is not None:
        return float(np.abs(line - q).max()), line, poses[-1]
    cost = 0.0 if waypoint.path == "plan" else _BROKEN_LINE
    for pose in poses[:: max(1, len(poses) // 4)] if len(poses) > 1 else poses:
        q_next = planner.reachable(q, pose, rng)
        cost += float(np.abs(q_next - q).max())
        q = q_next
    return cost, q, poses[-1]


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
    choices: list[RunChoice] = []
    cause: NoIkSolution | None = None
    for turn in _turns(run):
        try:
            choices.append(_try_turn(planner, run, turn, q, previous, rng))
        except NoIkSolution as error:
            cause = error
    if not choices:
        raise _out_of_reach(run, cause) from cause
    return sorted(choices, key=lambda choice: choice.cost)


def _turns(run: Sequence[Waypoint]) -> list[float]:
    """Turns of the hand that are alike for a run, from -pi to pi [rad]."""
    angles = (2.0 * np.pi * k / run[0].symmetry for k in range(run[0].symmetry))
    return [angle if angle <= np.pi else angle - 2.0 * np.pi for angle in angles]


def _out_of_reach(run: Sequence[Waypoint], cause: NoIkSolution | None) -> WaypointError:
    span = f"{run[0].index} to {run[-1].index}"
    return WaypointError(f"Waypoints {span} cannot be reached one after the other: {cause}")


def _some_turn(
    planner: MotionPlanner, run: Sequence[Waypoint], q: FloatArray, previous: FloatArray, rng: np.random.Generator
) -> RunChoice:
    """Return a turn that reaches every waypoint of a run: of those that break no line the one that begins nearest, if it can.

    Raises:
        WaypointError: There is none.
    """
    turns = _turns(run)
    # Broken lines, whether it has begun, how far it is, cost: all turns begin, then the foremost goes on.
    queue: list[tuple] = [(0, False, 0, 0.0, number, q, previous) for number in range(len(turns))]
    cause: NoIkSolution | None = None
    while queue:
        broken, _, ahead, cost, number, q, previous = heappop(queue)
        if -ahead == len(run):
            return RunChoice(turns[number], cost, q)
        try:
            more, q, previous = _visit(planner, run[-ahead], turns[number], q, previous, rng)
        except NoIkSolution as error:
            cause = error
        else:
            heappush(queue, (broken + (more >= _BROKEN_LINE), True, ahead - 1, cost + more, number, q, previous))
    raise _out_of_reach(run, cause) from cause


def check_feasible(planner: MotionPlanner, waypoints: Sequence[Waypoint], q: FloatArray, rng: np.random.Generator) -> None:
    """Raise WaypointError unless every waypoint can be reached in sequence, collisions ignored."""
    previous = planner.model.tip_pose(q)
    for run in runs([w for w in waypoints if not w.skip]):
        q = _some_turn(planner, run, q, previous, rng).q_end
        previous = planner.model.tip_pose(q)
