"""Reachability of the waypoints in the current layout, and the path to each.

Every segment begins where the one before it ends. Bodies that the gripper has touched or grasped will have moved when it comes
back, so from then on they no longer count as obstacles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from rlbench_pin.builder.contracts import PlannedPath, Standing, WaypointVerdict
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.waypoint_planning import grasp_groups, poses_of
from rlbench_pin.errors import GoalInCollision, NoIkSolution, NotStraight, PlanningError
from rlbench_pin.planning.kinematics import solve_ik
from rlbench_pin.planning.plan import Plan
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint
from rlbench_pin.viewer.recording import Failure

TURNS = 3
"""Symmetric grasps that are checked for collisions, those that reach most and move least first."""
QUICK_STARTS = 6
"""IK starts of the first attempt; if it finds no free configuration, as many as in a plan are used."""
_HOPELESS = 0.02
"""Position error above which other rotations about the z axis of the tip are not tried [m]."""
_SHOWN_PAIRS = 4
MAX_POINTS = 80
"""Points of a path that are shown at most."""
OTHER_STARTS = 24
"""Configurations that are tried if a straight line cannot be followed from the first one."""


@dataclass(frozen=True, eq=False)
class Visit:
    """The end of the segment to one waypoint."""

    waypoint: Waypoint
    poses: list[FloatArray]
    """Tip poses (7,) along the segment; it ends at the last."""
    fingers: float
    """Opening fraction of the gripper on the way."""
    allowed: tuple[str, ...]
    """Bodies that may be touched."""
    verdict: WaypointVerdict


@dataclass(eq=False)
class _Walk:
    """The state of the arm along the waypoints."""

    q: FloatArray
    """Configuration (n,) [rad]."""
    tip: FloatArray
    """Pose (7,) of the waypoint before."""
    fingers: float = 1.0
    """Opening fraction."""
    touched: frozenset[str] = frozenset()
    """Movable bodies that were touched or grasped."""
    turn: float = 0.0
    """Rotation of the gripper about its z axis [rad]."""
    visits: list[Visit] = field(default_factory=list)


class Reacher:
    """Checks the waypoints in the layout in which it is made.

    Args:
        runtime: The running task; its planner gets the current world.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime, self._planner, self._model = runtime, runtime.planner, runtime.model
        self._snapshot: WorldSnapshot = runtime.world.snapshot()
        bodies = runtime.world.bodies.values()
        self._movable = frozenset(body.name for body in bodies if body.joints or not body.fixed)

    def visits(self) -> tuple[Visit, ...]:
        """Return the visits of all waypoints that this episode does not skip, in order."""
        home = np.array(self._runtime.description.home)
        walk = _Walk(home, self._model.tip_pose(home))
        for run in grasp_groups([w for w in self._runtime.task.get_waypoints() if not w.skip]):
            walk = self._best(run, walk)
        return tuple(walk.visits)

    def pairs_at_home(self) -> tuple[tuple[str, str], ...]:
        """Return the links in contact when the arm is at home with its gripper open."""
        self.show(1.0)
        self._planner.collision.clear()
        return tuple(self._planner.collision.colliding_pairs(np.array(self._runtime.description.home)))

    def show(self, fingers: float) -> None:
        """Update the planner with the world and an opening fraction of the gripper."""
        joints = np.full(len(self._snapshot.fingers), fingers * self._runtime.description.gripper_open)
        self._planner.update(replace(self._snapshot, fingers=joints, attached=()))

    def _best(self, run: Sequence[Waypoint], start: _Walk) -> _Walk:
        """Go through a run with the first rotation of the gripper that is free, else with the best of a few, with more starts."""
        hopeless: dict[int, NoIkSolution] = {}
        walks: list[_Walk] = []
        for turn in self._ranked_turns(run, start, hopeless)[:TURNS]:
            walks.append(self._walk(run, start, turn, QUICK_STARTS, hopeless))
            if all(visit.verdict.standing == "free" for visit in walks[-1].visits[len(start.visits) :]):
                return walks[-1]
        best = max(walks, key=_merit)
        return max(best, self._walk(run, start, best.turn, self._planner.config.ik_starts, {}), key=_merit)

    def _ranked_turns(self, run: Sequence[Waypoint], start: _Walk, hopeless: dict[int, NoIkSolution]) -> list[float]:
        """Return the rotations of the gripper [rad], those that reach most waypoints with least motion first."""
        count = run[0].symmetry
        if count == 1:
            return [0.0]
        turns = [2.0 * np.pi * k / count for k in range(count)]
        turns = [turn if turn <= np.pi else turn - 2.0 * np.pi for turn in turns]
        tries = [(self._travel(run, start, turn, hopeless), turn) for turn in turns]
        return [turn for _, turn in sorted(tries, key=lambda tried: (-tried[0][0], tried[0][1]))]

    def _travel(self, run: Sequence[Waypoint], start: _Walk, turn: float, hopeless: dict[int, NoIkSolution]) -> tuple[int, float]:
        """Return the number of waypoints that are reached without regard to collisions, and the joint motion for that [rad]."""
        q, tip, reached, travel = start.q, start.tip, 0, 0.0
        for waypoint in run:
            tip = poses_of(waypoint, turn, tip)[-1]
            if waypoint.index in hopeless:
                continue
            try:
                q_next = self._solve(q, tip, QUICK_STARTS)
            except NoIkSolution as error:
                if error.position_error > _HOPELESS:
                    hopeless[waypoint.index] = error
                continue
            reached, travel, q = reached + 1, travel + float(np.abs(q_next - q).max()), q_next
        return reached, travel

    def _walk(
        self, run: Sequence[Waypoint], start: _Walk, turn: float, starts: int, hopeless: Mapping[int, NoIkSolution]
    ) -> _Walk:
        """Go through a run with one rotation of the gripper [rad]."""
        walk = _Walk(start.q, start.tip, start.fingers, start.touched, turn, list(start.visits))
        for waypoint in run:
            poses, allowed = poses_of(waypoint, walk.turn, walk.tip), tuple(sorted(walk.touched))
            self.show(walk.fingers)
            error = hopeless.get(waypoint.index)
            if error is not None:
                verdict = _unreachable(waypoint, poses, error)
            else:
                verdict = self._verdict(walk.q, waypoint, poses, allowed, starts)
            walk.visits.append(Visit(waypoint, poses, walk.fingers, allowed, verdict))
            walk.tip = poses[-1]
            if verdict.configuration is not None:
                walk.q = verdict.configuration
                walk.touched |= self._touched(walk.q)
                if waypoint.gripper is not None:
                    self.show(waypoint.gripper_amount)
                    walk.touched |= self._touched(walk.q)
            walk.fingers = waypoint.gripper_amount
        return walk

    def _touched(self, q: FloatArray) -> frozenset[str]:
        """Return the movable bodies in contact with the arm in a configuration (n,)."""
        self._planner.collision.clear()
        pairs = self._planner.collision.colliding_pairs(q) if self._planner.collision.in_collision(q) else []
        return frozenset(name for pair in pairs for name in pair if name in self._movable)

    def _verdict(
        self, q: FloatArray, waypoint: Waypoint, poses: Sequence[FloatArray], allowed: tuple[str, ...], starts: int
    ) -> WaypointVerdict:
        """Return how the arm gets from a configuration (n,) to the end of a segment."""
        name, contact = waypoint.frame.name, None
        step = max(1, len(poses) // 4)
        for pose in poses[::-step][::-1]:
            try:
                q, error = self._reach(q, pose, starts, waypoint.ignore_collisions, allowed)
                contact = contact or error
            except NoIkSolution as error:
                return _unreachable(waypoint, poses, error)
        if contact is None:
            return WaypointVerdict(name, "free", "", poses[-1], q)
        cause = _contact_text(contact)
        return WaypointVerdict(name, "collides", cause, poses[-1], q, Failure(cause, name, contact.pairs))

    def _reach(
        self, q: FloatArray, pose: FloatArray, starts: int, ignore: bool, allowed: tuple[str, ...]
    ) -> tuple[FloatArray, GoalInCollision | None]:
        """Return a configuration at a pose, and its contacts if none is free."""
        if ignore:
            return self._solve(q, pose, starts), None
        collision = self._planner.collision
        collision.clear()
        collision.allow(allowed)
        try:
            return self._solve(q, pose, starts, collision), None
        except GoalInCollision as error:
            return self._solve(q, pose, starts), error

    def _solve(self, q: FloatArray, pose: FloatArray, starts: int, collision: CollisionModel | None = None) -> FloatArray:
        rng = self._runtime.planning_rng
        return solve_ik(self._model, pose, q, rng, starts=starts, max_solutions=1, collision=collision)[0]


def verdicts(runtime: Runtime) -> tuple[WaypointVerdict, ...]:
    """Return the verdict on every waypoint, in order; waypoints that this episode skips are free.

    If the arm at home is in contact, no episode begins: the first waypoint reports it.
    """
    reacher = Reacher(runtime)
    found = {visit.waypoint.index: visit.verdict for visit in reacher.visits()}
    all_of_them = [
        found.get(w.index) or WaypointVerdict(w.frame.name, "free", "This episode leaves it out.", w.pose)
        for w in runtime.task.get_waypoints()
    ]
    if all_of_them and (pairs := reacher.pairs_at_home()):
        first = all_of_them[0]
        contacts = ", ".join(f"{one} with {other}" for one, other in pairs[:_SHOWN_PAIRS])
        cause = f"The arm at home touches something already, so that no episode begins: {contacts}. Move it away. {first.cause}"
        nearest = None if first.failure is None else first.failure.nearest
        failure = Failure(cause.strip(), first.waypoint, pairs, nearest)
        standing: Standing = "collides" if first.standing == "free" else first.standing
        all_of_them[0] = replace(first, standing=standing, cause=failure.cause, failure=failure)
    return tuple(all_of_them)


def _merit(walk: _Walk) -> tuple[int, int]:
    """Return a key by which most reached waypoints come first, then most free ones."""
    standings = [visit.verdict.standing for visit in walk.visits]
    return -standings.count("unreachable"), standings.count("free")


def _unreachable(waypoint: Waypoint, poses: Sequence[FloatArray], error: NoIkSolution) -> WaypointVerdict:
    lacks = []
    if error.position_error > 5e-4:
        lacks.append(f"{100.0 * error.position_error:.1f} cm too far")
    if error.rotation_error > np.radians(0.5):
        lacks.append(f"{np.degrees(error.rotation_error):.0f} deg from its orientation")
    cause = (
        f"Out of reach: the nearest pose of the gripper is {' and '.join(lacks) or 'just beside it'}. "
        "Move the waypoint or its parent towards the arm, or rotate it."
    )
    name = waypoint.frame.name
    return WaypointVerdict(name, "unreachable", cause, poses[-1], None, Failure(cause, name, (), error.nearest))


def _contact_text(error: GoalInCollision) -> str:
    pairs = [
        f"{first} with {second}" + (f" ({1000.0 * depth:.0f} mm deep)" if depth >= 5e-4 else "")
        for (first, second), depth in zip(error.pairs, error.depths, strict=True)
    ]
    more = f", and {len(pairs) - _SHOWN_PAIRS} more" if len(pairs) > _SHOWN_PAIRS else ""
    return (
        f"The gripper gets there, but touches something: {', '.join(pairs[:_SHOWN_PAIRS])}{more}. "
        "Move it away, or let the waypoint ignore collisions if contact is intended."
    )


# Paths ------------------------------------------------------------------------------------------------------------------------


def planned_paths(runtime: Runtime, on_path: Callable[[PlannedPath], None]) -> tuple[PlannedPath, ...]:
    """Plan the path to each waypoint as a demonstration in this layout would; a segment without a path is skipped.

    Args:
        runtime: The running task.
        on_path: Called with every path.
    """
    reacher, q, model = Reacher(runtime), np.array(runtime.description.home), runtime.model
    paths: list[PlannedPath] = []
    for visit in reacher.visits():
        reacher.show(visit.fingers)
        name = visit.waypoint.frame.name
        try:
            plan = _plan_somehow(runtime, visit, q)
        except PlanningError as error:
            paths.append(PlannedPath(name, np.zeros((0, 3)), "", str(error)))
            q = q if visit.verdict.configuration is None else visit.verdict.configuration
        else:
            count = min(len(plan.path), MAX_POINTS)
            chosen = np.unique(np.linspace(0, len(plan.path) - 1, count).round().astype(int))
            points = np.array([model.tip_pose(plan.path[i])[:3] for i in chosen])
            paths.append(PlannedPath(name, points, plan.report.method))
            q = np.array(plan.path[-1])
        on_path(paths[-1])
    return tuple(paths)


def _plan_somehow(runtime: Runtime, visit: Visit, q: FloatArray) -> Plan:
    """Plan from a configuration (n,); if a line cannot be followed from there, from others at the same pose of the tip.

    A demonstration ends the segment before in a configuration from which this one can be followed.
    """
    try:
        return _plan(runtime, visit, q)
    except NotStraight as error:
        limits, rng, tip = runtime.model.limits, runtime.planning_rng, runtime.model.tip_pose(q)
        for _ in range(OTHER_STARTS):
            with suppress(PlanningError):
                other = solve_ik(runtime.model, tip, rng.uniform(limits.lower, limits.upper), rng, starts=1)[0]
                return _plan(runtime, visit, other)
        raise error


def _plan(runtime: Runtime, visit: Visit, q: FloatArray) -> Plan:
    planner, waypoint, rng = runtime.planner, visit.waypoint, runtime.planning_rng
    if waypoint.path == "curve":
        return planner.plan_curve(q, visit.poses, ignore_collisions=True, rng=rng)
    return planner.plan_to_pose(
        q,
        visit.poses[0],
        straight=True if waypoint.path == "straight" else None,
        ignore_collisions=waypoint.ignore_collisions,
        allowed=visit.allowed,
        rng=rng,
    )
