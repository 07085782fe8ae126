"""The motion planner: collision-free, timed motions to a tip pose, to a joint configuration, or through a list of poses."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass

import numpy as np

from rlbench_pin.errors import GoalInCollision, InvalidRequest, NoIkSolution, NoPath, NotStraight
from rlbench_pin.planning.continuous_collision import ArmShapes, ContinuousCheck, Rules
from rlbench_pin.planning.kinematics import (
    PoseRegion,
    as_configuration,
    as_goal_poses,
    check_options,
    check_switches,
    cost,
    self_motions,
    solve_ik,
)
from rlbench_pin.planning.path import JointPath, along, curve_path, edge_is_free, straight_path, through
from rlbench_pin.planning.plan import Method, Plan, PlannerConfig, PlanningListeners, PlanReport, PlanRequest, Stages
from rlbench_pin.planning.search import path_around
from rlbench_pin.planning.timing import ArcLimits, TorqueLimits, retime
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.robot.dynamics import payload_inertia
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray, PoseLike, rotation_distance
from rlbench_pin.values import as_record


@dataclass(frozen=True, eq=False)
class _Found:
    path: JointPath
    method: Method
    goal: int


class MotionPlanner:
    """Plan collision-free, timed motions of one arm.

    Call `update` with a snapshot of the world, then `plan_to_pose`, `plan_to_configuration` or `plan_curve`. Each returns a
    `Plan` with a trajectory. The same world, arguments and generator state give the same plan.

    Attributes:
        limits: Joint limits of the motions: those of the arm, capped by `config`.
        collision: Collision model of the arm and the world.
        listeners: Objects that are notified of every update and every plan.
    """

    def __init__(self, model: RobotModel, config: PlannerConfig | None = None) -> None:
        """Prepare a planner in an empty world.

        Args:
            model: The arm.
            config: Settings; None takes the defaults.
        """
        self.model = as_record(model, RobotModel, "model", InvalidRequest)
        self.config = as_record(PlannerConfig() if config is None else config, PlannerConfig, "config", InvalidRequest)
        self.collision = CollisionModel(model)
        self._arm_shapes = ArmShapes(model)
        self.torque = TorqueLimits(model) if self.config.torque_limits else None
        self.limits = model.limits.capped(self.config.max_velocity, self.config.max_acceleration)
        self.listeners = PlanningListeners()

    def update(self, snapshot: WorldSnapshot) -> None:
        """Use the bodies of this snapshot as obstacles, and its held bodies as part of the arm."""
        as_record(snapshot, WorldSnapshot, "snapshot, as `world.snapshot()` makes one,", InvalidRequest)
        with self.listeners.update(snapshot):
            self.collision.update(snapshot)
            if self.torque is not None:
                self.torque.carry(payload_inertia(self.model, snapshot))

    def plan_to_pose(
        self,
        q_start: FloatArray,
        pose: PoseLike | Sequence[PoseLike] | PoseRegion,
        *,
        straight: bool | None = None,
        ignore_collisions: bool = False,
        allowed: Collection[str] = (),
        rng: np.random.Generator,
    ) -> Plan:
        """Plan a motion that brings the tip to a pose, or to one of several poses.

        Args:
            q_start: Start configuration (n,), [rad]. It may be up to 1e-3 rad beyond the joint limits; the motion then begins at
                the limits.
            pose: Goal pose of the tip in the world (7,), or a list of equally good poses, or a region of poses.
            straight: Straight line of the tip. None: try it first; True: accept nothing else; False: do not try it.
            ignore_collisions: Ignore collisions with the world. Collisions of the arm with itself are always avoided.
            allowed: Names of bodies that the arm may touch.
            rng: Generator of IK starts, samples and shortcuts.

        Raises:
            InvalidRequest: An argument has NaN, a wrong shape or a wrong type.
            OutsideJointLimits: The start is outside the joint limits.
            NoIkSolution: No goal pose is within reach.
            StartInCollision: The start is in a forbidden collision.
            GoalInCollision: Every configuration that reaches a goal pose collides.
            NotStraight: `straight` is True and the tip cannot follow a straight line to any goal pose.
            NoPath: A goal configuration is free of collisions, but no path to it was found.
            RetimingError: The path cannot be timed within the limits.
        """
        q = self._checked(q_start, rng, allowed, free=ignore_collisions)
        check_switches(straight=straight is not None and straight)
        poses = pose.sample(self.config.region_samples, rng) if isinstance(pose, PoseRegion) else as_goal_poses(pose)
        with self._open(PlanRequest("pose", q_start, pose, ignore_collisions, tuple(allowed))) as stages:
            rules = self._rules(stages, q, allowed, ignore_collisions)
            if straight is not False:
                found = self._straight(stages, q, poses, rules, limit=len(poses) if straight else 2, must=bool(straight))
                if found is not None:
                    return self._close(stages, found, rules)
            goals = self._goals(stages, q, poses, rng, self.collision)
            return self._close(stages, self._search(stages, q, goals, rules, rng), rules)

    def plan_to_configuration(
        self,
        q_start: FloatArray,
        q_goal: FloatArray,
        *,
        ignore_collisions: bool = False,
        allowed: Collection[str] = (),
        rng: np.random.Generator,
    ) -> Plan:
        """Plan a motion to a joint configuration (n,), [rad]; other arguments and errors as in `plan_to_pose`."""
        q, goal = self._checked(q_start, rng, allowed, free=ignore_collisions), self._within(q_goal, "goal configuration")
        with self._open(PlanRequest("configuration", q_start, q_goal, ignore_collisions, tuple(allowed))) as stages:
            rules = self._rules(stages, q, allowed, ignore_collisions)
            if self.collision.goal_in_collision(goal):
                pairs, depths = self.collision.penetrations(goal)
                raise GoalInCollision(pairs, 1, depths)
            return self._close(stages, self._search(stages, q, [(goal, 0)], rules, rng), rules)

    def plan_curve(
        self,
        q_start: FloatArray,
        poses: Sequence[PoseLike],
        *,
        ignore_collisions: bool = True,
        allowed: Collection[str] = (),
        rng: np.random.Generator | None = None,
    ) -> Plan:
        """Plan a motion in which the tip passes through `poses`, each (7,), in order and without stopping.

        Other arguments and errors are those of `plan_to_pose`, but collisions with the world are ignored by default.
        """
        unused = np.random.default_rng(0) if rng is None else rng
        q, poses = self._checked(q_start, unused, allowed, free=ignore_collisions), as_goal_poses(poses, "curve")
        with self._open(PlanRequest("curve", q_start, poses, ignore_collisions, tuple(allowed))) as stages:
            rules = self._rules(stages, q, allowed, ignore_collisions)
            with stages.stage("straight"):
                path = through(curve_path(self.model, q, poses, rules.is_free))
                self._require_free(path, rules)
            return self._close(stages, _Found(path, "curve", len(poses) - 1), rules)

    def reachable(
        self,
        q_seed: FloatArray,
        pose: PoseLike | Sequence[PoseLike],
        rng: np.random.Generator,
        ignore_collisions: bool = True,
        allowed: Collection[str] = (),
    ) -> FloatArray:
        """Return the configuration (n,) nearest to `q_seed` that reaches a pose, or one of several poses.

        Raises:
            NoIkSolution: No pose is within reach.
            GoalInCollision: `ignore_collisions` is False, and all configurations collide.
        """
        q = self._checked(q_seed, rng, allowed, "seed configuration", free=ignore_collisions)
        collision, poses = None if ignore_collisions else self.collision, as_goal_poses(pose)
        with self.listeners.reach():
            if collision is not None:
                collision.clear()
                collision.allow(allowed)
            return self._goals(Stages(checks=self.collision.checks), q, poses, rng, collision, branches=1)[0][0]

    @contextmanager
    def _open(self, request: PlanRequest) -> Iterator[Stages]:
        try:
            with self.listeners.plan(request, Stages(checks=self.collision.checks)) as stages:
                yield stages
        finally:
            if request.ignore_collisions:  # what is asked afterwards is meant of the whole world
                self.collision.clear()

    def _checked(
        self, q: FloatArray, rng: object, allowed: Collection[str], what: str = "start configuration", *, free: object
    ) -> FloatArray:
        """Check the arguments, and return the start within the joint limits."""
        check_options(rng, allowed, free)
        return self._within(q, what)

    def _within(self, q: FloatArray, what: str) -> FloatArray:
        """Return the nearest configuration (n,) within the joint limits, at most `JOINT_LIMIT_TOLERANCE` away."""
        return np.clip(as_configuration(self.model, q, what), self.limits.lower, self.limits.upper)

    def _rules(self, stages: Stages, q: FloatArray, allowed: Collection[str], ignore_collisions: bool) -> Rules:
        config, world = self.config, not ignore_collisions
        with stages.stage("rules"):
            self.collision.begin(q, margin=config.margin, own=config.own_margin, allowed=allowed, world=world)
        return Rules(self.collision, config, ContinuousCheck(self._arm_shapes, self.collision), world)

    def _straight(
        self, stages: Stages, q: FloatArray, poses: list[FloatArray], rules: Rules, limit: int, must: bool
    ) -> _Found | None:
        """Try straight lines to the `limit` poses with the smallest rotation; return None if there is none."""
        here = self.model.tip_pose(q)
        order = sorted(range(len(poses)), key=lambda i: rotation_distance(here, poses[i]))[:limit]
        failure: NotStraight | None = None
        with stages.stage("straight"):
            for i in order:
                try:
                    return _Found(self._line(q, poses[i], rules), "straight", i)
                except NotStraight as error:
                    failure = error if failure is None or error.fraction > failure.fraction else failure
        if must and failure is not None:
            raise failure
        return None

    def _line(self, q: FloatArray, pose: FloatArray, rules: Rules) -> JointPath:
        points = straight_path(self.model, q, pose)
        if not rules.is_free(points[-1]):
            if self.collision.goal_in_collision(points[-1]):
                raise NotStraight(1.0, "its end touches something")
            self.collision.relax(points[-1])
        path = through(points, np.linspace(0.0, 1.0, len(points)))
        self._require_free(path, rules)
        return path

    def _require_free(self, path: JointPath, rules: Rules) -> None:
        hit = rules.first_violation(path)
        if hit is not None:
            raise NotStraight(hit, "something is in the way", self.collision.colliding_pairs(path(hit)))

    def _goals(
        self,
        stages: Stages,
        q: FloatArray,
        poses: list[FloatArray],
        rng: np.random.Generator,
        collision: CollisionModel | None,
        branches: int | None = None,
    ) -> list[tuple[FloatArray, int]]:
        """Return goal configurations with the index of their pose, nearest first."""
        wanted = branches or self.config.branches
        found: list[tuple[FloatArray, int]] = []
        failures: list[NoIkSolution | GoalInCollision] = []
        with stages.stage("ik"):
            for i, pose in enumerate(poses):
                try:
                    solutions = solve_ik(
                        self.model, pose, q, rng, starts=self.config.ik_starts, max_solutions=wanted, collision=collision
                    )
                    found += [(solution, i) for solution in self._with_elbows(solutions, collision)]
                except (NoIkSolution, GoalInCollision) as error:
                    failures.append(error)
        if not found:
            raise next((e for e in failures if isinstance(e, GoalInCollision)), failures[0])
        return sorted(found, key=lambda item: cost(self.model, q, item[0]))[:wanted]

    def _with_elbows(self, solutions: list[FloatArray], collision: CollisionModel | None) -> list[FloatArray]:
        """Add configurations of a redundant arm with other elbow positions near the nearest solution, if settings enable it."""
        if self.config.elbows == 0:
            return solutions
        more = self_motions(self.model, solutions[0], count=self.config.elbows)
        return solutions + [q for q in more if collision is None or not collision.goal_in_collision(q)]

    def _search(
        self, stages: Stages, q: FloatArray, goals: list[tuple[FloatArray, int]], rules: Rules, rng: np.random.Generator
    ) -> _Found:
        """Return a smooth free path to one of the goals: the line in joint space if it is free, otherwise around obstacles."""
        with stages.stage("search"):
            for goal, index in goals:
                self.collision.relax(goal)
                if edge_is_free(q, goal, rules.is_free, self.config.edge_step):
                    path = along(np.array([q, goal]), 1.0)
                    if rules.first_violation(path) is None:
                        return _Found(path, "direct", index)
        path = self._around(q, [g for g, _ in goals], rules, rng, stages)
        nearest = min(goals, key=lambda item: float(np.abs(item[0] - path.end).max()))
        return _Found(path, "sampled", nearest[1])

    def _around(
        self, q: FloatArray, goals: list[FloatArray], rules: Rules, rng: np.random.Generator, stages: Stages
    ) -> JointPath:
        """Search with the preferred clearance, and if that fails, with the minimum clearance."""
        config, collision = self.config, self.collision
        if config.clearance > config.margin:
            with suppress(NoPath), collision.wider(config.clearance - config.margin, [q, *goals]):
                return path_around(q, goals, rules, self.limits, rng, stages)
        return path_around(q, goals, rules, self.limits, rng, stages)

    def _close(self, stages: Stages, found: _Found, rules: Rules) -> Plan:
        with stages.stage("retime"):
            arc = ArcLimits(self.config.max_velocity, self.config.max_acceleration)
            trajectory = retime(found.path, self.limits, arc=arc, torque=self.torque, jerk_time=self.config.jerk_time)
        report = PlanReport(
            method=found.method,
            goal=found.goal,
            length=found.path.length(),
            checks=self.collision.checks - stages.checks + rules.measured,
            clearance=self._clearance(found.path) if self.config.measure_clearance else None,
            seconds=stages.seconds,
            certified=rules.world and self.config.certify,
            doubts=rules.doubts,
        )
        stages.plan = Plan(trajectory, found.path.points(), report)
        return stages.plan

    def _clearance(self, path: JointPath) -> float:
        """Return the smallest distance to a forbidden contact along a path, with checks every 0.1 rad [m]."""
        return min((d.distance for q in path.spread(0.1)[1] for d in self.collision.distances(q)[:1]), default=float("inf"))
