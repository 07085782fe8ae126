"""Planning of the motion to a waypoint: selects the grasp angle, and a configuration from which the next motion is possible.

A symmetric grasp may be rotated about the z axis of the tip. A group is a sequence of waypoints that share one grasp angle:
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
"""Cost of a line that cannot be followed from the end of the previous segment [rad]; it favours other grasp angles."""
_NEAR = 0.15
"""Segments up to this length should be straight [m]; without collision checks they have to be."""
_OTHER_GOALS = 24
"""Maximum number of other end configurations of a segment, if the next motion is impossible from the first one."""


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
    """Return the tip poses (7,) of a segment from `previous` (7,) with a grasp angle [rad]."""
    if waypoint.path == "curve":
        return [rotated(pose, angle) for pose in waypoint.curve_poses(rotated(previous, -angle))]
    return [rotated(waypoint.pose, angle)]


def _followed(model: RobotModel, waypoint: Waypoint, q: FloatArray, poses: Sequence[FloatArray]) -> FloatArray:
    """Return configurations (m, n) from `q` (n,) whose tip follows the curve or a straight line; raise NotStraight."""
    return curve_path(model, q, poses) if waypoint.path == "curve" else straight_path(model, q, poses[-1])


# Feasibility of groups -----------------------------------------------------------------------------------------------


def _grasp_angles(group: Sequence[Waypoint]) -> list[float]:
    """Return the equivalent grasp angles of a group, from -pi to pi [rad]."""
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
        NoIkSolution: The waypoint is out of reach.
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
    """Return the grasp angles [rad] that reach a group from `q` (n,) and tip pose `previous`, least travel first.

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
    """Return a configuration (n,) after all waypoints of a group, preferably with a grasp angle that allows all lines.

    Raises:
        WaypointError: There is no such configuration.
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
    """A planned segment that can be executed."""

    angle: float
    """Grasp angle [rad]."""
    end: FloatArray
    """Tip pose at its end (7,)."""
    plan: Plan


class WaypointPlanner:
    """Plans from the present configuration to one waypoint.

    Args:
        runtime: World, model and planner.

    Attributes:
        angle: Grasp angle about the z axis of the tip [rad]: of the last plan, or the best one after `rank`.
        grasp: Waypoint of the last closing of the gripper; None after the gripper has opened.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._robot_links = set(runtime.robot.link_poses())
        self._arm_links = self._robot_links - {*runtime.model.fingers.links}
        self.angle = 0.0
        self.grasp: Waypoint | None = None

    def rank(self, group: Sequence[Waypoint]) -> list[float]:
        """Return the grasp angles that reach a group of waypoints, best first [rad].

        Raises:
            WaypointError: There is no such angle.
        """
        runtime, angles = self._runtime, [0.0]
        if group[0].symmetry > 1:
            kept, tip = [w for w in group if not w.skip], runtime.robot.tip_pose()
            angles = _rank_angles(runtime.planner, kept, runtime.measured_start, tip, runtime.planning_rng)
        self.angle = angles[0]
        return angles

    def plan(self, waypoint: Waypoint, rest: Sequence[Waypoint], angles: Sequence[float]) -> Plan:
        """Plan with the first of `angles` for which a plan exists.

        Args:
            waypoint: Goal of the segment.
            rest: The waypoints after it in its group, which should be reachable from there.
            angles: Grasp angles to try [rad].

        Raises:
            PlanningError: No angle has a plan; this is the error of the first angle.
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
        """Return the tip pose (7,) that moves the held object to its pose for `pose` (7,) and an exact grasp.

        The waypoint of the grasp moves with the held object and is the exact tip pose on it; `tip` (7,) is the present one.
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
        """Yield segments from `q` (n,) to other end configurations, from which the next motion is possible."""
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
        """Return whether the segment from `tip` (7,) to `pose` (7,) has to be a line or a curve."""
        return waypoint.path != "plan" or (waypoint.ignore_collisions and _is_near(tip, pose))

    def _can_go_on(self, q: FloatArray, rest: Sequence[Waypoint], angle: float) -> bool:
        """Return whether the segments after configuration `q` (n,) can be followed, up to the first long free segment.

        On segments without collision checks the gripper may touch bodies, but the arm may not; only the first one is checked.
        Self-collisions of the arm are never allowed.
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
        """Return whether the arm touches itself in configuration `q` (n,)."""
        pairs = self._runtime.planner.collision.colliding_pairs(q)
        return any(set(pair) <= self._robot_links for pair in pairs)

    def _arm_touches(self, q: FloatArray) -> bool:
        """Return whether a link of the arm, without the gripper, touches a body in configuration `q` (n,)."""
        return any(pair & self._arm_links for pair in map(set, self._runtime.planner.collision.colliding_pairs(q)))


def _is_near(tip: FloatArray, pose: FloatArray) -> bool:
    return bool(np.linalg.norm(pose[:3] - tip[:3]) <= _NEAR)
