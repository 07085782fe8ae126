"""Skills of the classical baseline: motions of the gripper, planned and followed."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin

from rlbench_pin.baselines.perception import TABLE, Axis, Cloud, View, look, near
from rlbench_pin.control import DifferentialIK, DifferentialIKConfig, PostureObjective, TrajectoryFollower, VelocityFollowing
from rlbench_pin.errors import GoalInCollision, PlanningError, RlbenchPinError
from rlbench_pin.observation import Observation
from rlbench_pin.planning import MotionPlanner, PlannerConfig, solve_ik, straight_path
from rlbench_pin.robot import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray, se3_to_pose

PAD = 0.0095
"""Distance from the tip frame to the ends of the fingers [m]."""
DOWN = np.array([0.0, 0.0, -1.0])
"""Direction from the gripper to the table, a unit vector (3,)."""


class NothingFound(RlbenchPinError):
    """No object of the instruction is seen, or no recipe matches the instruction."""


def pointing(direction: FloatArray, across: FloatArray) -> FloatArray:
    """Return the gripper orientation (3, 3) that points along `direction`, with the fingers apart along `across`.

    The fingers are apart along the component of `across` that is perpendicular to `direction`.
    """
    z = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
    y = np.asarray(across, dtype=float) - (z @ across) * z
    y = y / np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z], axis=1)


def both_ways(turns: Sequence[FloatArray]) -> list[FloatArray]:
    """Return each rotation, followed by the same rotation with the fingers swapped."""
    half = np.diag([-1.0, -1.0, 1.0])
    return [turn @ t for turn in turns for t in (np.eye(3), half)]


def down(yaw: float) -> FloatArray:
    """Return the gripper orientation (3, 3) that points down, with the fingers apart along a heading [rad]."""
    return pointing(DOWN, np.array([np.cos(yaw), np.sin(yaw), 0.0]))


def all_down(count: int = 8) -> list[FloatArray]:
    """Return `count` gripper orientations that point down, with evenly spaced headings."""
    return [down(float(yaw)) for yaw in np.linspace(-np.pi, np.pi, count, endpoint=False)]


def sloping(direction: FloatArray, slopes: Sequence[float], turns: Sequence[float] = (0.0,)) -> list[FloatArray]:
    """Return gripper orientations that point along a horizontal direction, with each slope and each rotation about the vertical.

    Args:
        direction: Horizontal direction (3,).
        slopes: Angles of the gripper below the horizontal [rad].
        turns: Rotations about the vertical [rad].
    """
    found = []
    for turn in turns:
        level = pin.rpy.rpyToMatrix(0.0, 0.0, turn) @ direction
        for slope in slopes:
            z = np.cos(slope) * level + np.sin(slope) * DOWN
            found += [pointing(z, across) for across in (np.cross(level, DOWN), np.cross(z, np.cross(level, DOWN)))]
    return both_ways(found)


def placed(turn: FloatArray, point: FloatArray) -> pin.SE3:
    """Return the gripper placement with an orientation (3, 3) and the tip at a point (3,) [m]."""
    return pin.SE3(np.asarray(turn), np.asarray(point, dtype=float))


PULLING = 0.1
"""Speed of the tip while it pulls an object [m/s]."""
ABOVE = 0.1
"""Distance to the object at which an approach starts [m]."""


def touch(gripper: Gripper, point: FloatArray, turns: Sequence[FloatArray]) -> Moves:
    """Move the tip to a point (3,) [m], with the best of several orientations (3, 3)."""
    yield from gripper.go(gripper.choose([[placed(turn, point)] for turn in turns]))


def press(gripper: Gripper, point: FloatArray, turns: Sequence[FloatArray], back: float = ABOVE) -> Moves:
    """Push the closed fingers to a point (3,) [m] along the gripper axis, and move back by `back` [m]."""
    way = gripper.choose([approach(turn, point, back) for turn in turns])
    yield from gripper.go(way, is_open=False)
    yield from gripper.slide(way.targets[1:])
    yield from gripper.slide(way.targets[:1])


def pull(gripper: Gripper, way: Way) -> Moves:
    """Move to the first placement of a way, grasp at the second, and move slowly along the others with the grasped part."""
    yield from gripper.go(way, is_open=True)
    yield from gripper.slide(way.targets[1:2])
    yield from gripper.grip(False)
    yield from gripper.slide(way.targets[2:], PULLING)


def pick(gripper: Gripper, point: FloatArray, turns: Sequence[FloatArray], lift: float = ABOVE) -> Moves:
    """Grasp at a point (3,) [m], and lift the object straight up by `lift` [m]."""
    up = np.array([0.0, 0.0, lift])
    way = gripper.choose([[*approach(turn, point, ABOVE), placed(turn, point + up)] for turn in turns])
    yield from gripper.go(way, is_open=True)
    yield from gripper.slide(way.targets[1:2])
    yield from gripper.grip(False)
    yield from gripper.slide(way.targets[2:])


def place(gripper: Gripper, point: FloatArray, over: float = ABOVE) -> Moves:
    """Move the held object to `over` [m] above a point (3,) [m], lower it, release it, and move up again."""
    turn, up = gripper.tip.rotation, np.array([0.0, 0.0, over])
    turns = [turn @ pin.rpy.rpyToMatrix(0.0, 0.0, yaw) for yaw in (0.0, np.pi, 0.5 * np.pi, -0.5 * np.pi)]
    way = gripper.choose([[placed(t, point + up), placed(t, point)] for t in turns])
    yield from gripper.go(way)
    yield from gripper.slide(way.targets[1:])
    yield from gripper.grip(True)
    yield from gripper.slide(way.targets[:1])


def sweep(gripper: Gripper, paths: Sequence[Sequence[pin.SE3]], back: FloatArray) -> Moves:
    """Move along the best of several paths, the fingers closed.

    Args:
        gripper: The gripper.
        paths: Alternative paths; each is a sequence of placements of the tip.
        back: Offset (3,) from the start of a path to the end of the free motion [m].
    """
    way = gripper.choose([[pin.SE3(path[0].rotation, path[0].translation + back), *path] for path in paths])
    yield from gripper.go(way, is_open=False)
    yield from gripper.slide(way.targets[1:])


def arc(axis: Axis, point: FloatArray, angles: Iterable[float]) -> list[FloatArray]:
    """Return a point (3,) [m] rotated about an axis, once for each angle [rad]."""
    offset = point - axis.origin
    return [axis.origin + pin.exp3(angle * axis.direction) @ offset for angle in angles]


def approach(turn: FloatArray, point: FloatArray, back: float) -> list[pin.SE3]:
    """Return two placements of the gripper: `back` [m] before a point (3,) [m] along its z-axis, and at the point."""
    return [placed(turn, point - back * turn[:, 2]), placed(turn, point)]


TARGET_RADIUS = 0.07
"""Obstacles nearer than this to the target of the tip may be touched [m]."""
PLANNING = PlannerConfig(
    max_velocity=1.5, margin=0.008, clearance=0.02, certify=False, ik_starts=15, checks=6000, attempts=1, simplify_checks=600
)
"""Settings of the planner for free motions."""


class Driver:
    """Planner in a world of boxes, trajectory follower and Cartesian controller for one arm.

    Args:
        arm: The arm.
        period: Time of a control tick [s].
    """

    def __init__(self, arm: RobotModel, period: float) -> None:
        self.arm, self.period = arm, period
        self._planner = MotionPlanner(arm, PLANNING)
        self._following = VelocityFollowing(arm.limits, period)
        posture = PostureObjective(gain=0.0)
        self._cartesian = DifferentialIK(arm, DifferentialIKConfig(dt=period, posture=posture))
        self._world: WorldSnapshot | None = None

    def update(self, objects: Cloud, q: FloatArray, fingers: FloatArray) -> None:
        """Set the obstacles of the planner.

        Args:
            objects: Detected points of the objects.
            q: Joint positions of the arm (n,) [rad].
            fingers: Positions of the fingers (2,) [m].
        """
        self._world = WorldSnapshot.from_point_cloud(objects.points, q, fingers, boxes={"table": TABLE})
        self._planner.update(self._world)

    def reach(self, q: FloatArray, target: pin.SE3, rng: np.random.Generator) -> tuple[FloatArray, bool]:
        """Return the configuration (n,) [rad] nearest to `q` with the tip at `target`, and whether it is free of collisions.

        Raises:
            NoIkSolution: The arm cannot reach the target.
        """
        pose = se3_to_pose(target)
        try:
            return self._planner.reachable(q, pose, rng, ignore_collisions=False, allowed=self._obstacles_at(target)), True
        except GoalInCollision:
            return solve_ik(self.arm, pose, q, rng, starts=10)[0], False

    def plan(self, q: FloatArray, goal: FloatArray, rng: np.random.Generator) -> tuple[Trajectory, bool]:
        """Return a timed motion from `q` to `goal`, both (n,) [rad], and whether it avoids the obstacles.

        Without a collision-free motion it is a straight motion in joint space.
        """
        try:
            allowed = self._obstacles_at(self.arm.tip_se3(goal))
            return self._planner.plan_to_configuration(q, goal, allowed=allowed, rng=rng).trajectory, True
        except PlanningError:
            return self._planner.plan_to_configuration(q, goal, ignore_collisions=True, rng=rng).trajectory, False

    def follower(self, trajectory: Trajectory) -> TrajectoryFollower:
        """Return a controller that computes the joint velocity of each tick along a trajectory."""
        return TrajectoryFollower(trajectory, self._following)

    def towards(self, q: FloatArray, v: FloatArray, target: pin.SE3) -> FloatArray:
        """Return the joint velocity (n,) [rad/s] that moves the tip to a placement in one tick, within the limits.

        Args:
            q: Measured configuration (n,) [rad].
            v: Last command (n,) [rad/s].
            target: Placement of the tip after the tick.
        """
        here = self.arm.tip_se3(q)
        turn = pin.log3(target.rotation @ here.rotation.T)
        twist = np.concatenate([target.translation - here.translation, turn]) / self.period
        return self._cartesian.velocity_for_twist(q, v, twist)

    def _obstacles_at(self, target: pin.SE3) -> list[str]:
        """Return the names of the obstacles at a target of the tip; the gripper may touch them."""
        return [] if self._world is None else near(self._world, target.translation, TARGET_RADIUS)


SPEED, TURNING = 0.2, 1.0
"""Speed of the tip on a straight motion [m/s], and its angular speed [rad/s]."""
RAMP_TICKS = 4
"""Ticks that the tip needs for acceleration to this speed; deceleration takes about as many."""
LAG = 0.015
"""Maximum distance to the current station before the target advances [m]; 1 rad counts as 0.1 m."""
THERE = 0.002
"""Maximum distance to a reached target [m] or joint position [rad]."""
PATIENCE = 8
"""Ticks without progress after which a motion is aborted."""
PLANS = 4
"""Maximum number of ways for which a free motion to the start is planned."""


@dataclass(frozen=True, eq=False)
class Tick:
    """One action: joint velocities, and the state of the fingers."""

    velocity: FloatArray
    """Joint velocities (n,) [rad/s]."""
    is_open: bool
    """Whether the fingers are commanded open."""


Moves = Generator[Tick, Observation, None]
"""A skill: a generator that yields actions and receives the observation after each action."""


@dataclass(frozen=True, eq=False)
class Way:
    """Path of the tip, with a free motion to its start."""

    targets: Sequence[pin.SE3]
    """Placements of the tip, in order."""
    motion: Trajectory
    """Motion from the current configuration to the first placement."""


class Gripper:
    """The gripper and its arm: the last observation, and the motions that skills consist of.

    Args:
        driver: Planner and controllers of the arm.
        observation: First observation of the episode.
        rng: Random generator of the planner.
    """

    def __init__(self, driver: Driver, observation: Observation, rng: np.random.Generator) -> None:
        self.seen, self._driver, self._rng = observation, driver, rng
        self.is_open = True
        self._arm, self._zero = driver.arm, np.zeros(driver.arm.size)
        self._view: tuple[Observation, View] | None = None
        self._home = self.joints

    def look(self) -> View:
        """Return the points of the objects and of the table in the last observation."""
        if self._view is None or self._view[0] is not self.seen:
            self._view = self.seen, look(self.seen, self._arm)
        return self._view[1]

    @property
    def joints(self) -> FloatArray:
        """Measured joint positions of the arm (n,) [rad], clipped to the limits."""
        measured = np.asarray(self.seen.joint_positions, dtype=float)
        return np.clip(measured, self._arm.limits.lower, self._arm.limits.upper)

    @property
    def tip(self) -> pin.SE3:
        """Measured placement of the tip."""
        return self._arm.tip_se3(self.joints)

    # Moving -------------------------------------------------------------------------------------------------------

    def go(self, way: Way, is_open: bool | None = None) -> Moves:
        """Open or close the fingers (None: leave them), then follow the free motion to the first placement of a way."""
        yield from self.grip(is_open)
        yield from self._follow(way.motion)

    def go_home(self) -> Moves:
        """Plan and follow a free motion to the joint positions at the start of the episode."""
        self._driver.update(self.look().objects, self.joints, self._fingers)
        yield from self._follow(self._driver.plan(self.joints, self._home, self._rng)[0])

    def slide(self, targets: Sequence[pin.SE3], speed: float = SPEED) -> Moves:
        """Move the tip on straight lines through placements.

        The target waits while the tip lags behind; after `PATIENCE` such ticks the motion ends.
        """
        share = self._driver.period / RAMP_TICKS
        segments = pairwise([self.tip, *targets])
        stations = [station for a, b in segments for station in line(a, b, share * speed, share * TURNING)]
        v, k, advance, late, last = self._zero, -1, 0, 0, len(stations) - 1
        while late < PATIENCE:
            if k < last and (k < 0 or apart(self.tip, stations[k]) < LAG):
                advance, late = min(advance + 1, RAMP_TICKS, 1 + (last - k) // RAMP_TICKS), 0
                k = min(k + advance, last)
            else:
                advance, late = 0, late + 1
            v = self._driver.towards(self.joints, v, stations[k])
            yield from self._tick(v)
            if k == last and apart(self.tip, stations[last]) < THERE:
                return

    def shift(self, by: Iterable[float]) -> Moves:
        """Move the tip straight by a vector (3,) [m] in world coordinates."""
        here = self.tip
        yield from self.slide([pin.SE3(here.rotation, here.translation + np.array(list(by)))])

    def grip(self, is_open: bool | None) -> Moves:
        """Open or close the fingers without motion of the arm; do nothing for None, or if they already are in this state."""
        if is_open is not None and is_open != self.is_open:
            self.is_open = is_open
            yield from self._tick(self._zero)

    def rest(self, ticks: int) -> Moves:
        """Hold the position for some ticks."""
        for _ in range(ticks):
            yield from self._tick(self._zero)

    def _follow(self, motion: Trajectory) -> Moves:
        """Follow a timed motion until the joints reach its end, or `PATIENCE` ticks longer than planned."""
        follower, v, late = self._driver.follower(motion), self._zero, 0
        while late < PATIENCE:
            v = follower.command(self.joints, v)
            yield from self._tick(v)
            late += follower.done
            if follower.done and np.abs(self.joints - motion.q[-1]).max() < THERE:
                return

    def _tick(self, velocity: FloatArray) -> Moves:
        """Yield one action, and store the next observation."""
        self.seen = yield Tick(velocity, self.is_open)

    # Choosing -----------------------------------------------------------------------------------------------------

    def choose(self, ways: Sequence[Sequence[pin.SE3]]) -> Way:
        """Return the way of which the arm can follow most placements.

        Ties are resolved in favour of a start without collision, then of the smallest joint motion.

        Raises:
            NothingFound: The arm can reach the start of none of them.
        """
        self._driver.update(self.look().objects, self.joints, self._fingers)
        scored = sorted(((*self._follows(way), k) for k, way in enumerate(ways)), key=lambda s: (-s[0], not s[1], s[2], s[4]))
        best: Way | None = None
        for reached, _, _, start, k in scored[:PLANS]:
            if start is None or reached < scored[0][0]:
                break
            motion, is_free = self._driver.plan(self.joints, start, self._rng)
            if is_free or best is None:
                best = Way(ways[k], motion)
            if is_free:
                break
        if best is None:
            raise NothingFound("The arm reaches none of the target placements.")
        return best

    def _follows(self, way: Sequence[pin.SE3]) -> tuple[int, bool, float, FloatArray | None]:
        """Test how far the arm can follow a way.

        Returns:
            Number of reachable placements (the first with any motion, the others on straight lines), whether the start is free
            of collisions, the sum of joint motions [rad], and the configuration at the start (n,) [rad], or None.
        """
        try:
            start, is_free = self._driver.reach(self.joints, way[0], self._rng)
        except PlanningError:
            return 0, False, 0.0, None
        q, reached, motion = start, 1, float(np.abs(start - self.joints).sum())
        for target in way[1:]:
            try:
                path = straight_path(self._arm, q, se3_to_pose(target))
            except PlanningError:
                break
            motion += float(np.abs(np.diff(path, axis=0)).sum())
            q, reached = np.clip(path[-1], self._arm.limits.lower, self._arm.limits.upper), reached + 1
        return reached, is_free, motion, start

    @property
    def _fingers(self) -> FloatArray:
        """Measured positions of the fingers (2,) [m]."""
        return np.asarray(self.seen.gripper_joint_positions, dtype=float)


def line(start: pin.SE3, end: pin.SE3, step: float, turn: float) -> list[pin.SE3]:
    """Return the placements after `start` on a straight line to `end`, at most `step` [m] and `turn` [rad] apart."""
    shift, rotation = end.translation - start.translation, pin.log3(start.rotation.T @ end.rotation)
    count = max(1, int(np.ceil(max(np.linalg.norm(shift) / step, np.linalg.norm(rotation) / turn))))
    shares = [k / count for k in range(1, count + 1)]
    return [pin.SE3(start.rotation @ pin.exp3(u * rotation), start.translation + u * shift) for u in shares]


def apart(a: pin.SE3, b: pin.SE3) -> float:
    """Return the distance of two placements [m]; a rotation of 1 rad counts as 0.1 m."""
    turn = float(np.linalg.norm(pin.log3(a.rotation.T @ b.rotation)))
    return float(np.linalg.norm(a.translation - b.translation)) + 0.1 * turn
