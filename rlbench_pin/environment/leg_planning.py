"""Planning one leg of a demonstration: which turn of the hand, and a configuration from which the arm can go on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.turns import poses_of, rank_turns
from rlbench_pin.errors import NotStraight, PlanningError
from rlbench_pin.planning.plan import Plan
from rlbench_pin.planning.straight import curve_path, straight_path
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint

_NEAR = 0.15
"""A leg without collision checks that is no longer than this should be straight [m]."""
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
        choices = rank_turns(runtime.planner, kept, runtime.robot.joint_positions, runtime.robot.tip_pose(), runtime.planning_rng)
        return [choice.turn for choice in choices]

    def plan(self, waypoint: Waypoint, following: Waypoint | None, turns: Sequence[float]) -> Plan:
        """Plan with the first of `turns` that works.

        Args:
            waypoint: Where to.
            following: The waypoint after it in its run, which the arm should reach from there.
            turns: Turns of the hand to try [rad].

        Raises:
            PlanningError: None of them works; the error of the first.
        """
        self._runtime.refresh_planner()
        error: PlanningError | None = None
        for turn in turns:
            try:
                plan = self._plan_ahead(waypoint, following, turn)
            except PlanningError as failure:
                error = error or failure
                continue
            self.turn = turn
            return plan
        assert error is not None
        raise error

    def _plan_ahead(self, waypoint: Waypoint, following: Waypoint | None, turn: float) -> Plan:
        """Return a plan, if need be to another configuration at the same pose, from which the arm can go on straight."""
        plan = self._plan_turn(waypoint, turn)
        if waypoint.path != "plan" or self._can_go_on(plan.path[-1], following, turn):
            return plan
        runtime, rng = self._runtime, self._runtime.planning_rng
        q, pose = runtime.robot.joint_positions, poses_of(waypoint, turn, runtime.robot.tip_pose())[0]
        limits, ignore, allowed = runtime.planner.limits, waypoint.ignore_collisions, runtime.touching()
        for _ in range(_OTHER_GOALS):
            start = rng.uniform(limits.lower, limits.upper)
            try:
                goal = runtime.planner.reachable(start, pose, rng, ignore_collisions=ignore, allowed=allowed)
                if self._can_go_on(goal, following, turn):
                    return runtime.planner.plan_to_configuration(q, goal, ignore_collisions=ignore, allowed=allowed, rng=rng)
            except PlanningError:
                continue
        return plan

    def _plan_turn(self, waypoint: Waypoint, turn: float) -> Plan:
        runtime, rng = self._runtime, self._runtime.planning_rng
        q = runtime.robot.joint_positions
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

    def _can_go_on(self, q: FloatArray, following: Waypoint | None, turn: float) -> bool:
        """Whether the following leg, if it has to be a line or a curve, can be followed from configuration `q` (n,)."""
        if following is None:
            return True
        model = self._runtime.model
        tip = model.tip_pose(q)
        poses = poses_of(following, turn, tip)
        near = following.ignore_collisions and np.linalg.norm(poses[-1][:3] - tip[:3]) <= _NEAR
        try:
            if following.path == "curve":
                curve_path(model, q, poses)
            elif following.path == "straight" or near:
                straight_path(model, q, poses[-1])
        except NotStraight:
            return False
        return True
