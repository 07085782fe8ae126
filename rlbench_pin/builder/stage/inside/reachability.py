"""Whether the hand gets to each waypoint, one after the other, in the layout as it stands: free, touching something, or not.

Every leg begins where the one before it ends. What the hand has touched or held on the way will have moved by the time it comes
back, so from then on it no longer counts as being in the way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rlbench_pin.builder.contracts import Failure, Standing, WaypointVerdict
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.waypoint_planning import grasp_groups, poses_of
from rlbench_pin.errors import GoalInCollision, NoIkSolution
from rlbench_pin.planning.kinematics import solve_ik
from rlbench_pin.robot.collision import CollisionModel
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint

TURNS = 3
"""Turns of a symmetric hand that are looked at for collisions, those that reach most and move least first."""
QUICK_STARTS = 6
"""Descents of a first look; where it finds no free way, all are tried that a plan would try."""
_HOPELESS = 0.02
"""A tip that stays farther away than this is not brought there by turning the hand about its own z [m]."""
_SHOWN_PAIRS = 4


@dataclass(frozen=True, eq=False)
class Visit:
    """The end of the leg to one waypoint."""

    waypoint: Waypoint
    poses: list[FloatArray]
    """Tip poses (7,) that are passed; the last is where it ends."""
    fingers: float
    """Opening fraction of the hand on the way."""
    allowed: tuple[str, ...]
    """Bodies that may be touched."""
    verdict: WaypointVerdict


@dataclass(eq=False)
class Walk:
    """Where the arm is on its way through the waypoints, and what it has touched."""

    q: FloatArray
    """Configuration (n,) [rad]."""
    tip: FloatArray
    """Pose (7,) that the waypoint before asked for."""
    fingers: float = 1.0
    """Opening fraction."""
    touched: frozenset[str] = frozenset()
    """Bodies that can move and were touched or held."""
    turn: float = 0.0
    """Of the hand about its own z [rad]."""
    visits: list[Visit] = field(default_factory=list)


class Reacher:
    """Looks at the waypoints of the layout in which it is made.

    Args:
        runtime: The running task; its planner is given the world as it is.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime, self._planner, self._model = runtime, runtime.planner, runtime.model
        self._snapshot: WorldSnapshot = runtime.world.snapshot()
        self._open = runtime.description.gripper_open
        bodies = runtime.world.bodies.values()
        self._movable = frozenset(body.name for body in bodies if body.joints or not body.fixed)

    def visits(self) -> tuple[Visit, ...]:
        """Return the visits of all waypoints that this episode does not leave out, in order."""
        home = np.array(self._runtime.description.home)
        walk = Walk(home, self._model.tip_pose(home))
        for run in grasp_groups([w for w in self._runtime.task.get_waypoints() if not w.skip]):
            walk = self._best(run, walk)
        return tuple(walk.visits)

    def pairs_at_home(self) -> tuple[tuple[str, str], ...]:
        """Return what the arm at home, with its hand open, touches already: names of links."""
        self.show(1.0)
        self._planner.collision.clear()
        return tuple(self._planner.collision.colliding_pairs(np.array(self._runtime.description.home)))

    def show(self, fingers: float) -> None:
        """Give the planner the world with the fingers at an opening fraction."""
        joints = np.full(len(self._snapshot.fingers), fingers * self._open)
        self._planner.update(replace(self._snapshot, fingers=joints, attached=()))

    def _best(self, run: Sequence[Waypoint], start: Walk) -> Walk:
        """Go through a run with the turn of the hand that is free, or else the best of a few, looked at more closely."""
        hopeless: dict[int, NoIkSolution] = {}
        walks: list[Walk] = []
        for turn in self._ranked_turns(run, start, hopeless)[:TURNS]:
            walks.append(self._walk(run, start, turn, QUICK_STARTS, hopeless))
            if all(visit.verdict.standing == "free" for visit in walks[-1].visits[len(start.visits) :]):
                return walks[-1]
        best = max(walks, key=_merit)
        return max(best, self._walk(run, start, best.turn, self._planner.config.ik_starts, {}), key=_merit)

    def _ranked_turns(self, run: Sequence[Waypoint], start: Walk, hopeless: dict[int, NoIkSolution]) -> list[float]:
        """Return the turns of the hand [rad], those that reach most waypoints with least travel first; collisions are ignored."""
        count = run[0].symmetry
        if count == 1:
            return [0.0]
        turns = [2.0 * np.pi * k / count for k in range(count)]
        turns = [turn if turn <= np.pi else turn - 2.0 * np.pi for turn in turns]
        tries = [(self._travel(run, start, turn, hopeless), turn) for turn in turns]
        return [turn for _, turn in sorted(tries, key=lambda tried: (-tried[0][0], tried[0][1]))]

    def _travel(self, run: Sequence[Waypoint], start: Walk, turn: float, hopeless: dict[int, NoIkSolution]) -> tuple[int, float]:
        """Return how many waypoints of a run are reached, and how far the joints travel for that [rad]."""
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

    def _walk(self, run: Sequence[Waypoint], start: Walk, turn: float, starts: int, hopeless: Mapping[int, NoIkSolution]) -> Walk:
        """Go through a run with one turn of the hand [rad]."""
        walk = Walk(start.q, start.tip, start.fingers, start.touched, turn, list(start.visits))
        for waypoint in run:
            self._visit(walk, waypoint, starts, hopeless.get(waypoint.index))
        return walk

    def _visit(self, walk: Walk, waypoint: Waypoint, starts: int, out_of_reach: NoIkSolution | None) -> None:
        """Go to one waypoint, and let the hand act there."""
        poses, allowed = poses_of(waypoint, walk.turn, walk.tip), tuple(sorted(walk.touched))
        self.show(walk.fingers)
        verdict = _red(waypoint, poses, out_of_reach) if out_of_reach else self._verdict(walk.q, waypoint, poses, allowed, starts)
        walk.visits.append(Visit(waypoint, poses, walk.fingers, allowed, verdict))
        walk.tip = poses[-1]
        if verdict.configuration is not None:
            walk.q = verdict.configuration
            walk.touched |= self._touched(walk.q)
            if waypoint.gripper is not None:
                self.show(waypoint.gripper_amount)
                walk.touched |= self._touched(walk.q)
        walk.fingers = waypoint.gripper_amount

    def _touched(self, q: FloatArray) -> frozenset[str]:
        """Return the bodies that can move and touch the arm in a configuration (n,)."""
        self._planner.collision.clear()
        pairs = self._planner.collision.colliding_pairs(q) if self._planner.collision.in_collision(q) else []
        return frozenset(name for pair in pairs for name in pair if name in self._movable)

    def _verdict(
        self, q: FloatArray, waypoint: Waypoint, poses: Sequence[FloatArray], allowed: tuple[str, ...], starts: int
    ) -> WaypointVerdict:
        """Say how the arm gets from a configuration (n,) to the end of a leg."""
        name, touching = waypoint.frame.name, None
        step = max(1, len(poses) // 4)
        for pose in poses[::-step][::-1]:
            try:
                q, error = self._reach(q, pose, starts, waypoint.ignore_collisions, allowed)
                touching = touching or error
            except NoIkSolution as error:
                return _red(waypoint, poses, error)
        if touching is None:
            return WaypointVerdict(name, "free", "", poses[-1], q)
        cause = _touch_text(touching)
        return WaypointVerdict(name, "collides", cause, poses[-1], q, Failure(cause, name, touching.pairs))

    def _reach(
        self, q: FloatArray, pose: FloatArray, starts: int, ignore: bool, allowed: tuple[str, ...]
    ) -> tuple[FloatArray, GoalInCollision | None]:
        """Return a configuration at a pose, and what it touches when none is free."""
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
    """Return the verdict on every waypoint, in order; those that this episode leaves out are free.

    When the arm at home touches something already, no episode begins: the first waypoint says so.
    """
    reacher = Reacher(runtime)
    found = {visit.waypoint.index: visit.verdict for visit in reacher.visits()}
    said = tuple(found.get(w.index) or _left_out(w) for w in runtime.task.get_waypoints())
    pairs = reacher.pairs_at_home() if said else ()
    return (_blocked(said[0], pairs), *said[1:]) if pairs else said


def _blocked(first: WaypointVerdict, pairs: tuple[tuple[str, str], ...]) -> WaypointVerdict:
    """Return the verdict on the first waypoint, of an arm that touches something before it moves."""
    touching = ", ".join(f"{one} with {other}" for one, other in pairs[:_SHOWN_PAIRS])
    cause = f"The arm at home touches something already, so that no episode begins: {touching}. Move it away. {first.cause}"
    nearest = None if first.failure is None else first.failure.nearest
    failure = Failure(cause.strip(), first.waypoint, pairs, nearest)
    standing: Standing = "collides" if first.standing == "free" else first.standing
    return replace(first, standing=standing, cause=failure.cause, failure=failure)


def _merit(walk: Walk) -> tuple[int, int]:
    """Most reached first, then most that are free."""
    standings = [visit.verdict.standing for visit in walk.visits]
    return -standings.count("unreachable"), standings.count("free")


def _red(waypoint: Waypoint, poses: Sequence[FloatArray], error: NoIkSolution) -> WaypointVerdict:
    cause, name = _distance_text(error), waypoint.frame.name
    return WaypointVerdict(name, "unreachable", cause, poses[-1], None, Failure(cause, name, (), error.nearest))


def _left_out(waypoint: Waypoint) -> WaypointVerdict:
    return WaypointVerdict(waypoint.frame.name, "free", "This episode leaves it out.", waypoint.pose)


def _distance_text(error: NoIkSolution) -> str:
    """Say what is missing: how far the tip stays away, and how much it lacks in turning."""
    lacks = []
    if error.position_error > 5e-4:
        lacks.append(f"{100.0 * error.position_error:.1f} cm too far")
    if error.rotation_error > np.radians(0.5):
        lacks.append(f"{np.degrees(error.rotation_error):.0f} deg short of its turn")
    return (
        f"Out of reach: the nearest pose of the hand is {' and '.join(lacks) or 'just beside it'}. "
        "Move the waypoint, or what it belongs to, towards the arm, or turn it."
    )


def _touch_text(error: GoalInCollision) -> str:
    pairs = [
        f"{first} with {second}" + (f" ({1000.0 * depth:.0f} mm deep)" if depth >= 5e-4 else "")
        for (first, second), depth in zip(error.pairs, error.depths, strict=True)
    ]
    more = f", and {len(pairs) - _SHOWN_PAIRS} more" if len(pairs) > _SHOWN_PAIRS else ""
    return (
        f"The hand gets there, but touches something: {', '.join(pairs[:_SHOWN_PAIRS])}{more}. "
        "Move it away, or let the waypoint ignore collisions when it is meant to touch."
    )
