"""Planning the motion to a waypoint: which grasp angle, and a configuration from which the arm can go on.

A symmetric grasp may be rotated about the z axis of the tip. A group is a stretch of waypoints that must share one grasp angle:
they have the same symmetry, and a release ends the group.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np

from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import NoIkSolution, NotStraight, PlanningError, WaypointError
from rlbench_pin.planning.path import curve_path, straight_path
from rlbench_pin.planning.plan import Plan
from rlbench_pin.planning.planner import MotionPlanner
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, compose, relative
from rlbench_pin.tasks import Waypoint

_BROKEN_LINE = 10.0
"""Cost of a line that cannot be followed from where the segment before it would end: another grasp angle is better [rad]."""
_NEAR = 0.15
"""A segment that is no longer than this should be straight; without collision checks it has to be [m]."""
_OTHER_GOALS = 24
"""Configurations at the end of a segment that are tried when the arm could not go on from the first one."""


def grasp_groups(waypoints: Sequence[Waypoint]) -> list[list[Waypoint]]:
    """Split waypoints into the groups that share one grasp angle."""
    result: list[list[Waypoint]] = []
    for waypoint in waypoints:
        new = not result or result[-1][-1].lets_go or result[-1][-1].symmetry != waypoint.symmetry
        if new:
            result.append([])
        result[-1].append(waypoint)
    return result


def rotated(pose: FloatArray, angle: float) -> FloatArray:
    """Rotate a tip pose (7,) about its own z axis by `angle` [rad]."""
    if angle == 0.0:
        return pose
    return compose(pose, [0.0, 0.0, 0.0, 0.0, 0.0, np.sin(angle / 2.0), np.cos(angle / 2.0)])


def poses_of(waypoint: Waypoint, angle: float, previous: FloatArray) -> list[FloatArray]:
    """Return the tip poses (7,) that a segment passes with a grasp angle [rad]; it begins at `previous` (7,)."""
    if waypoint.path == "curve":
        return [rotated(pose, angle) for pose in waypoint.curve_poses(rotated(previous, -angle))]
    return [rotated(waypoint.pose, angle)]


def _followed(model: RobotModel, waypoint: Waypoint, q: FloatArray, poses: Sequence[FloatArray]) -> FloatArray:
    """Return configurations (m, n) from `q` (n,) on, whose tip follows the curve, or a straight line; raises NotStraight."""
    return curve_path(model, q, poses) if waypoint.path == "curve" else straight_path(model, q, poses[-1])


# Feasibility of groups -----------------------------------------------------------------------------------------------


def _grasp_angles(group: Sequence[Waypoint]) -> list[float]:
    """Equivalent grasp angles of a group, from -pi to pi [rad]."""
    angles = (2.0 * np.pi * k / group[0].symmetry for k in range(group[0].symmetry))
    return [angle if angle <= np.pi else angle - 2.0 * np.pi for angle in angles]


def _out_of_reach(group: Sequence[Waypoint], cause: NoIkSolution | None) -> WaypointError:
    span = f"{group[0].index} to {group[-1].index}"
    return WaypointError(f"Waypoints {span} cannot be reached one after the other: {cause}")


def _visit(
    planner: MotionPlanner, waypoint: Waypoint, angle: float, q: FloatArray, previous: FloatArray, rng: np.random.Generator
) -> tuple[float, FloatArray, FloatArray]:
    """Return the joint travel to a waypoint with a grasp angle [rad], the configuration there and the last tip pose.

    Raises:
        NoIkSolution: It is out of reach.
    """
    poses, cost = poses_of(waypoint, angle, previous), 0.0
    if waypoint.path != "plan":
        try:
            line = np.array(_followed(planner.model, waypoint, q, poses)[-1])
            return float(np.abs(line - q).max()), line, poses[-1]
        except NotStraight:
            cost = _BROKEN_LINE
    for pose in poses[:: max(1, len(poses) // 4)] if len(poses) > 1 else poses:
        q_next = planner.reachable(q, pose, rng)
        cost += float(np.abs(q_next - q).max())
        q = q_next
    return cost, q, poses[-1]


def _rank_angles(
    planner: MotionPlanner, group: Sequence[Waypoint], q: FloatArray, previous: FloatArray, rng: np.random.Generator
) -> list[float]:
    """Return the grasp angles [rad] with which a group can be reached from `q` (n,) and tip pose `previous`, least travel first.

    Raises:
        WaypointError: No angle reaches every waypoint of the group.
    """
    choices: list[tuple[float, float]] = []
    cause: NoIkSolution | None = None
    for angle in _grasp_angles(group):
        here, tip, cost = q, previous, 0.0
        try:
            for waypoint in group:
                more, here, tip = _visit(planner, waypoint, angle, here, tip, rng)
                cost += more
        except NoIkSolution as error:
            cause = error
        else:
            choices.append((cost, angle))
    if not choices:
        raise _out_of_reach(group, cause) from cause
    return [angle for _, angle in sorted(choices, key=lambda choice: choice[0])]


def _end_of_group(
    planner: MotionPlanner, group: Sequence[Waypoint], q: FloatArray, previous: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Return a configuration (n,) after every waypoint of a group, with a grasp angle that breaks no line if there is one.

    Raises:
        WaypointError: There is none.
    """
    angles = _grasp_angles(group)
    # Broken lines, whether it has begun, how far it is, cost: all angles begin, then the foremost goes on.
    queue: list[tuple] = [(0, False, 0, 0.0, number, q, previous) for number in range(len(angles))]
    cause: NoIkSolution | None = None
    while queue:
        broken, _, ahead, cost, number, q, previous = heappop(queue)
        if -ahead == len(group):
            return q
        try:
            more, q, previous = _visit(planner, group[-ahead], angles[number], q, previous, rng)
        except NoIkSolution as error:
            cause = error
        else:
            heappush(queue, (broken + (more >= _BROKEN_LINE), True, ahead - 1, cost + more, number, q, previous))
    raise _out_of_reach(group, cause) from cause


def check_feasible(planner: MotionPlanner, waypoints: Sequence[Waypoint], q: FloatArray, rng: np.random.Generator) -> None:
    """Raise WaypointError unless every waypoint can be reached in sequence from `q` (n,), collisions ignored."""
    previous = planner.model.tip_pose(q)
    for group in grasp_groups([w for w in waypoints if not w.skip]):
        q = _end_of_group(planner, group, q, previous, rng)
        previous = planner.model.tip_pose(q)


# Segments ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A planned segment that may be run."""

    angle: float
    """Grasp angle [rad]."""
    end: FloatArray
    """Tip pose at its end (7,)."""
    plan: Plan


class WaypointPlanner:
    """Plans from where the arm is to one waypoint.

    Args:
        runtime: World, model and planner.

    Attributes:
        angle: Grasp angle about the z axis of the tip [rad]: the one that was planned last, or after `rank` the best.
        grasp: Waypoint at which the gripper closed last; None where it has opened since.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._robot_links = set(runtime.robot.link_poses())
        self._arm_links = self._robot_links - {*runtime.model.fingers.links}
        self.angle = 0.0
        self.grasp: Waypoint | None = None

    def rank(self, group: Sequence[Waypoint]) -> list[float]:
        """Return the grasp angles that a group of waypoints can be reached with, best first [rad].

        Raises:
            WaypointError: There is none.
        """
        runtime, angles = self._runtime, [0.0]
        if group[0].symmetry > 1:
            kept, tip = [w for w in group if not w.skip], runtime.robot.tip_pose()
            angles = _rank_angles(runtime.planner, kept, runtime.measured_start, tip, runtime.planning_rng)
        self.angle = angles[0]
        return angles

    def plan(self, waypoint: Waypoint, rest: Sequence[Waypoint], angles: Sequence[float]) -> Plan:
        """Plan with the first of `angles` that works.

        Args:
            waypoint: Goal of the segment.
            rest: The waypoints after it in its group, which the arm should reach from there.
            angles: Grasp angles to try [rad].

        Raises:
            PlanningError: None of them works; the error of the first.
        """
        self._runtime.refresh_planner()
        q, tip = self._runtime.measured_start, self._runtime.robot.tip_pose()
        first_error: PlanningError | None = None
        found: list[_Candidate] = []
        for angle in angles:
            poses = poses_of(waypoint, angle, tip)
            if waypoint.compliant:
                poses = [self._as_held(poses[-1], angle, tip)]
            try:
                candidate = _Candidate(angle, poses[-1], self._plan_poses(waypoint, poses, q))
            except PlanningError as error:
                first_error = first_error or error
                continue
            if self._must_follow(waypoint, tip, candidate.end) or self._can_go_on(candidate.plan.path[-1], rest, angle):
                found = [candidate]
                break
            found.append(candidate)
        else:
            if not found:
                assert first_error is not None
                raise first_error
            found = [next(self._other_goals(waypoint, rest, found, q), found[0])]
        self.angle = found[0].angle
        if waypoint.gripper is not None:
            self.grasp = None if waypoint.releases else waypoint
        return found[0].plan

    def _as_held(self, pose: FloatArray, angle: float, tip: FloatArray) -> FloatArray:
        """Return the tip pose (7,) that brings what is held to where `pose` (7,) would bring it after an exact grasp.

        The waypoint of the grasp moves with what is held, so it is where the tip should be on it; `tip` (7,) is where it is.
        """
        grasp, held = self.grasp, self._runtime.gripper.held
        if grasp is None or not any(grasp.frame.moves_with(name) for name in held):
            return pose
        return compose(pose, relative(tip, rotated(grasp.pose, angle)))

    def _plan_poses(self, waypoint: Waypoint, poses: list[FloatArray], q: FloatArray) -> Plan:
        """Plan from `q` (n,) along the poses of a segment."""
        runtime = self._runtime
        if waypoint.path == "curve":
            return runtime.planner.plan_curve(q, poses, ignore_collisions=True, rng=runtime.planning_rng)
        return runtime.planner.plan_to_pose(
            q,
            poses[0],
            straight=True if waypoint.path == "straight" else None,
            ignore_collisions=waypoint.ignore_collisions,
            allowed=runtime.touching(),
            rng=runtime.planning_rng,
        )

    def _other_goals(
        self, waypoint: Waypoint, rest: Sequence[Waypoint], found: Sequence[_Candidate], q: FloatArray
    ) -> Iterator[_Candidate]:
        """Yield segments from `q` (n,) to other configurations at the ends of those found, from which the arm can go on."""
        runtime, rng = self._runtime, self._runtime.planning_rng
        planner, ignore, allowed = runtime.planner, waypoint.ignore_collisions, runtime.touching()
        for _ in range(_OTHER_GOALS):
            start = rng.uniform(planner.limits.lower, planner.limits.upper)
            for candidate in found:
                try:
                    goal = planner.reachable(start, candidate.end, rng, ignore_collisions=ignore, allowed=allowed)
                    if self._can_go_on(goal, rest, candidate.angle):
                        plan = planner.plan_to_configuration(q, goal, ignore_collisions=ignore, allowed=allowed, rng=rng)
                        yield _Candidate(candidate.angle, candidate.end, plan)
                except PlanningError:
                    continue

    @staticmethod
    def _must_follow(waypoint: Waypoint, tip: FloatArray, pose: FloatArray) -> bool:
        """Whether the segment from `tip` (7,) to `pose` (7,) has to be a line or a curve."""
        return waypoint.path != "plan" or (waypoint.ignore_collisions and _is_near(tip, pose))

    def _can_go_on(self, q: FloatArray, rest: Sequence[Waypoint], angle: float) -> bool:
        """Whether the segments after configuration `q` (n,) can be followed, up to the first long one that may go another way.

        On segments without collision checks the gripper may touch bodies, but not the arm behind it; only the first is looked at.
        The arm may never be inside itself.
        """
        model, first = self._runtime.model, True
        for following in rest:
            tip = model.tip_pose(q)
            poses = poses_of(following, angle, tip)
            must = self._must_follow(following, tip, poses[-1])
            if not must and not _is_near(tip, poses[-1]):
                return True
            try:
                path = _followed(model, following, q, poses)
            except NotStraight:
                return not must
            if must and first and any(self._arm_touches(q) for q in path[:: max(1, len(path) // 4)]):
                return False
            if must and any(self._is_folded(q) for q in path[::-2]):
                return False
            q, first = path[-1], False
        return True

    def _is_folded(self, q: FloatArray) -> bool:
        """Whether the arm touches itself in configuration `q` (n,)."""
        pairs = self._runtime.planner.collision.colliding_pairs(q)
        return any(set(pair) <= self._robot_links for pair in pairs)

    def _arm_touches(self, q: FloatArray) -> bool:
        """Whether a link of the arm before the gripper touches anything in configuration `q` (n,)."""
        return any(pair & self._arm_links for pair in map(set, self._runtime.planner.collision.colliding_pairs(q)))


def _is_near(tip: FloatArray, pose: FloatArray) -> bool:
    return bool(np.linalg.norm(pose[:3] - tip[:3]) <= _NEAR)
