"""The path of a demo: waypoints -> planned, timed, tracked motion -> observations."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest

import numpy as np

from rlbench_pin.environment.motion import follow, move_gripper
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.turns import poses_of, rank_turns, runs
from rlbench_pin.errors import DemoError, NotStraight, NoWaypointsError, PlanningError, RlbenchPinError, WaypointError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.planning.planner import Plan
from rlbench_pin.planning.straight import curve_path, straight_path
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint

_EXTRA_TICKS = 10
_NEAR = 0.15
"""A leg without collision checks that is no longer than this should be straight [m]."""
_OTHER_WAYS = 24
_MAX_ROUNDS = 40


@dataclass(frozen=True)
class LegReport:
    """One leg of a demonstration."""

    waypoint: int
    method: str
    planning_time: float
    """Time of this process [s]."""
    duration: float
    """Length of the motion [s]."""


@dataclass(frozen=True)
class DemoOutcome:
    """One try at a demonstration."""

    success: bool
    cause: str
    """Empty, or why it failed."""
    leg: int | None
    """Waypoint at which it failed."""
    demo: Demo | None
    planning_time: float
    """Time of this process [s]."""
    duration: float
    """Simulated time [s]."""
    legs: tuple[LegReport, ...] = field(default=())


class DemoPlayer:
    """Plays the waypoints of the running task once.

    Args:
        runtime: A scene at the start of an episode.
        record: Keep observations.
        record_gripper: Keep one observation per tick of finger motion, not only the last.
        on_frame: Called with every observation kept.
    """

    def __init__(
        self,
        runtime: Runtime,
        *,
        record: bool = True,
        record_gripper: bool = False,
        on_frame: Callable[[Observation], None] | None = None,
    ) -> None:
        self.runtime, self.record, self.record_gripper, self.on_frame = runtime, record, record_gripper, on_frame
        self.frames: list[Observation] = []
        self.legs: list[LegReport] = []
        self.waypoint: Waypoint | None = None
        self._following: Waypoint | None = None
        self._amount = 1.0
        self._target = runtime.robot.joint_positions
        self._chosen_turn = 0.0
        self._succeeded = False

    @property
    def planning_time(self) -> float:
        """Time of this process spent planning so far [s]."""
        return sum(leg.planning_time for leg in self.legs)

    def play(self) -> list[Observation]:
        """Run the demonstration and return its observations.

        Raises:
            NoWaypointsError: The task has none.
            DemoError: The goal was not reached, or the fail list ended the episode.
            WaypointError: A waypoint is out of reach.
            PlanningError: A leg could not be planned.
        """
        task = self.runtime.task
        if not task.get_waypoints():
            raise NoWaypointsError(f"Task '{task.get_name()}' has no waypoints, so it cannot be demonstrated.", task)
        self._frame()
        for _ in range(_MAX_ROUNDS):
            self._succeeded = False
            for waypoint, turns in self._legs():
                self._run_leg(waypoint, turns)
            repeat = task.should_repeat_waypoints()
            if self._succeeded or not repeat:
                break
        self._wait_for_success()
        return self.frames

    def _legs(self) -> Iterator[tuple[Waypoint, list[float]]]:
        """Yield each waypoint that is not skipped, with the turns of the hand to try, best first.

        Start hooks run here, before the poses of their leg are read.
        """
        waypoints = self.runtime.task.get_waypoints()
        for run in runs(waypoints):
            turns: list[float] | None = None
            for waypoint, following in zip_longest(run, run[1:]):
                self.waypoint, self._following = waypoint, following
                waypoint.run_start_hook()
                if waypoint.skip:
                    continue
                if turns is None:
                    turns = self._rank(run)
                self._chosen_turn = turns[0]
                yield waypoint, turns
                turns = [self._chosen_turn]

    def _rank(self, run: Sequence[Waypoint]) -> list[float]:
        if run[0].symmetry == 1:
            return [0.0]
        runtime = self.runtime
        alive = [w for w in run if not w.skip]
        choices = rank_turns(
            runtime.planner, alive, runtime.robot.joint_positions, runtime.robot.tip_pose(), runtime.planning_rng
        )
        return [choice.turn for choice in choices]

    def _run_leg(self, waypoint: Waypoint, turns: Sequence[float]) -> None:
        self._succeeded = False
        plan = self._plan(waypoint, turns)
        follow(self.runtime, plan.trajectory, until=self._check, on_tick=self._arm_tick)
        if waypoint.gripper is not None:
            self._operate_gripper(waypoint)
        waypoint.run_end_hook()

    def _plan(self, waypoint: Waypoint, turns: Sequence[float]) -> Plan:
        started = time.process_time()
        self.runtime.refresh_planner()
        error: PlanningError | None = None
        for turn in turns:
            try:
                plan = self._looking_ahead(waypoint, turn, self._plan_turn(waypoint, turn))
            except PlanningError as failure:
                error = error or failure
                continue
            self._chosen_turn = turn
            elapsed = time.process_time() - started
            self.legs.append(LegReport(waypoint.index, plan.report.method, elapsed, plan.trajectory.duration))
            return plan
        assert error is not None
        raise error

    def _plan_turn(self, waypoint: Waypoint, turn: float) -> Plan:
        runtime, rng = self.runtime, self.runtime.planning_rng
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

    def _looking_ahead(self, waypoint: Waypoint, turn: float, plan: Plan) -> Plan:
        """Return the plan, or one to another configuration at the same pose if the arm could not go on straight from its end."""
        if waypoint.path != "plan" or self._goes_on(plan.path[-1], turn):
            return plan
        runtime, rng = self.runtime, self.runtime.planning_rng
        q, pose = runtime.robot.joint_positions, poses_of(waypoint, turn, runtime.robot.tip_pose())[0]
        limits, blind, allowed = runtime.planner.limits, waypoint.ignore_collisions, runtime.touching()
        for _ in range(_OTHER_WAYS):
            start = rng.uniform(limits.lower, limits.upper)
            try:
                goal = runtime.planner.reachable(start, pose, rng, ignore_collisions=blind, allowed=allowed)
                if self._goes_on(goal, turn):
                    return runtime.planner.plan_to_configuration(q, goal, ignore_collisions=blind, allowed=allowed, rng=rng)
            except PlanningError:
                continue
        return plan

    def _goes_on(self, q: FloatArray, turn: float) -> bool:
        """Whether the next leg, if it has to be a line or a curve, can be followed from configuration `q` (n,)."""
        following, model = self._following, self.runtime.model
        if following is None:
            return True
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

    def _operate_gripper(self, waypoint: Waypoint) -> None:
        self._amount = waypoint.gripper_amount
        move_gripper(
            self.runtime,
            self._amount,
            release=waypoint.releases,
            speed=self.runtime.description.grip_speed,
            on_tick=self._gripper_tick,
        )
        if not self.record_gripper:
            self._frame()
        self._check()

    def _arm_tick(self, target: FloatArray) -> None:
        self._target = target
        self._frame()

    def _gripper_tick(self) -> None:
        self._check()
        if self.record_gripper:
            self._frame()

    def _check(self) -> bool:
        """Note success; raise when the fail list ends the episode. Never cuts a motion short."""
        success, terminate = self.runtime.task.success()
        if terminate and not success:
            raise DemoError("The fail list of the task was met.", self.runtime.task)
        self._succeeded = self._succeeded or success
        return False

    def _wait_for_success(self) -> None:
        self._check()
        for _ in range(_EXTRA_TICKS):
            if self._succeeded:
                return
            self.runtime.drive_to(self._target)
            self._frame()
            self._check()
        if not self._succeeded:
            raise DemoError("All waypoints were visited but the goal was not reached.", self.runtime.task)

    def _frame(self) -> None:
        if not self.record:
            return
        observation = self.runtime.get_observation()
        if self.frames:
            observation.misc["joint_position_action"] = np.append(self._target, self._amount)
        self.frames.append(observation)
        if self.on_frame is not None:
            self.on_frame(observation)


def try_play(player: DemoPlayer) -> tuple[str, int | None]:
    """Play and return the cause of failure, empty on success, and the waypoint it happened at."""
    try:
        player.play()
    except (PlanningError, WaypointError, DemoError) as error:
        leg = None if player.waypoint is None else player.waypoint.index
        return f"{_kind(error)}: {error}", leg
    return "", None


def _kind(error: RlbenchPinError) -> str:
    return error.reason if isinstance(error, PlanningError) else type(error).__name__
