"""Planning one leg of a demonstration: which turn of the hand, and a configuration from which the arm can go on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.turns import poses_of, rank_turns
from rlbench_pin.errors import NotStraight, PlanningError
from rlbench_pin.planning.plan import Plan
from rlbench_pin.planning.straight import curve_path, straight_path
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint

_NEAR = 0.15
"""A leg that is no longer than this should be straight; without collision checks it has to be [m]."""
_OTHER_GOALS = 24
"""Configurations at the end of a leg that are tried when the arm could not go on from the first one."""


class LegPlanner:
    """Plans from where the arm is to one waypoint.

    Args:
        runtime: What moves.

    Attributes:
        turn: Turn of the hand about its own z [rad]: the one that was planned last, or after `rank` the best.
    """

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        description = runtime.description
        self._robot_links = set(runtime.robot.link_poses())
        self._arm_links = self._robot_links - {description.hand_link, *description.finger_links}
        self.turn = 0.0

    def rank(self, run: Sequence[Waypoint]) -> list[float]:
        """Return the turns of the hand that a run of waypoints can be reached with, best first [rad].

        Raises:
            WaypointError: There is none.
        """
        turns = [0.0] if run[0].symmetry == 1 else self._rank(run)
        self.turn = turns[0]
        return turns

    def _rank(self, run: Sequence[Waypoint]) -> list[float]:
        runtime = self._runtime
        kept = [w for w in run if not w.skip]
        choices = rank_turns(runtime.planner, kept, runtime.measured_start, runtime.robot.tip_pose(), runtime.planning_rng)
        return [choice.turn for choice in choices]

    def plan(self, waypoint: Waypoint, rest: Sequence[Waypoint], turns: Sequence[float]) -> Plan:
        """Plan with the first of `turns` that works.

        Args:
            waypoint: Where to.
            rest: The waypoints after it in its run, which the arm should reach from there.
            turns: Turns of the hand to try [rad].

        Raises:
            PlanningError: None of them works; the error of the first.
        """
        self._runtime.refresh_planner()
        error: PlanningError | None = None
        found: list[tuple[float, Plan]] = []
        for turn in turns:
            try:
                plan = self._plan_turn(waypoint, turn)
            except PlanningError as failure:
                error = error or failure
                continue
            if self._leads_on(plan, waypoint, rest, turn):
                self.turn = turn
                return plan
            found.append((turn, plan))
        if not found:
            assert error is not None
            raise error
        self.turn, plan = next(self._other_goals(waypoint, rest, [turn for turn, _ in found]), found[0])
        return plan

    def _leads_on(self, plan: Plan, waypoint: Waypoint, rest: Sequence[Waypoint], turn: float) -> bool:
        """Whether the arm can go on from the end of a plan, or could not end anywhere else."""
        tip = self._runtime.robot.tip_pose()
        pose = poses_of(waypoint, turn, tip)[-1]
        return self._has_to_be_followed(waypoint, tip, pose) or self._can_go_on(plan.path[-1], rest, turn)

    def _other_goals(self, waypoint: Waypoint, rest: Sequence[Waypoint], turns: Sequence[float]) -> Iterator[tuple[float, Plan]]:
        """Yield plans to other configurations at the same pose, from which the arm can go on, with their turns."""
        runtime, rng = self._runtime, self._runtime.planning_rng
        q, tip, allowed = runtime.measured_start, runtime.robot.tip_pose(), runtime.touching()
        limits, ignore = runtime.planner.limits, waypoint.ignore_collisions
        ends = [(turn, poses_of(waypoint, turn, tip)[-1]) for turn in turns]
        for _ in range(_OTHER_GOALS):
            start = rng.uniform(limits.lower, limits.upper)
            for turn, pose in ends:
                try:
                    goal = runtime.planner.reachable(start, pose, rng, ignore_collisions=ignore, allowed=allowed)
                    if self._can_go_on(goal, rest, turn):
                        yield (
                            turn,
                            runtime.planner.plan_to_configuration(q, goal, ignore_collisions=ignore, allowed=allowed, rng=rng),
                        )
                except PlanningError:
                    continue

    def _plan_turn(self, waypoint: Waypoint, turn: float) -> Plan:
        runtime, rng = self._runtime, self._runtime.planning_rng
        q = runtime.measured_start
        poses = poses_of(waypoint, turn, runtime.robot.tip_pose())
        if waypoint.path == "curve":
            return runtime.planner.plan_curve(q, poses, ignore_collisions=True, rng=rng)
        return runtime.planner.plan_to_pose(
            q,
            poses[0],
            straight=True if waypoint.path == "straight" else None,
            ignore_collisions=waypoint.ignore_collisions,
            allowed=runtime.touching(),
            rng=rng,
        )

    @staticmethod
    def _has_to_be_followed(waypoint: Waypoint, tip: FloatArray, pose: FloatArray) -> bool:
        """Whether the leg from `tip` (7,) to `pose` (7,) has to be a line or a curve."""
        return waypoint.path != "plan" or (waypoint.ignore_collisions and _is_near(tip, pose))

    def _can_go_on(self, q: FloatArray, rest: Sequence[Waypoint], turn: float) -> bool:
        """Whether the legs after configuration `q` (n,) can be followed, up to the first long one that may go another way.

        On legs without collision checks the hand may touch things, but not the arm behind it; only the first is looked at. The
        arm may never be inside itself.
        """
        model, first = self._runtime.model, True
        for following in rest:
            tip = model.tip_pose(q)
            poses = poses_of(following, turn, tip)
            must = self._has_to_be_followed(following, tip, poses[-1])
            if not must and not _is_near(tip, poses[-1]):
                return True
            try:
                path = curve_path(model, q, poses) if following.path == "curve" else straight_path(model, q, poses[-1])
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
        """Whether a link of the arm before the hand touches anything in configuration `q` (n,)."""
        return any(pair & self._arm_links for pair in map(set, self._runtime.planner.collision.colliding_pairs(q)))


def _is_near(tip: FloatArray, pose: FloatArray) -> bool:
    return bool(np.linalg.norm(pose[:3] - tip[:3]) <= _NEAR)
