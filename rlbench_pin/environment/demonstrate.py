"""The path of a demo: waypoints -> planned, timed, tracked motion -> observations."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from rlbench_pin.environment.leg_planning import LegPlanner
from rlbench_pin.environment.motion import follow, move_gripper
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.environment.turns import runs
from rlbench_pin.errors import DemoError, NoWaypointsError, PlanningError, RlbenchPinError, WaypointError
from rlbench_pin.observation import Demo, Observation
from rlbench_pin.planning.plan import Plan
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Waypoint

EXTRA_TICKS = 10
"""Control ticks that a demonstration waits for its success after the last leg."""
MAX_ROUNDS = 40
"""How often the waypoints of a task are visited at most."""


@dataclass(frozen=True, kw_only=True)
class Omission:
    """What a demonstration leaves out, to show that it fails without."""

    waypoints: tuple[int, ...] = ()
    """Numbers of waypoints that are not visited."""
    grasps: bool = False
    """The hand does not close on anything."""


@dataclass(frozen=True)
class LegReport:
    """One leg of a demonstration."""

    waypoint: int
    """Number of the waypoint that it leads to."""
    method: str
    """How it was planned: straight, direct, sampled or curve."""
    planning_time: float
    """Time of this process [s]."""
    duration: float
    """Length of the motion [s]."""


@dataclass(frozen=True)
class DemoOutcome:
    """One try at a demonstration."""

    success: bool
    """Whether the goal was reached."""
    cause: str
    """Empty, or why it failed."""
    leg: int | None
    """Waypoint at which it failed; None when it succeeded."""
    demo: Demo | None
    """The demonstration, None when it failed."""
    planning_time: float
    """Time of this process [s]."""
    duration: float
    """Simulated time [s]."""
    legs: tuple[LegReport, ...] = field(default=())
    """The legs that were run."""


class DemoPlayer:
    """Plays the waypoints of the running task once.

    Args:
        runtime: A task at the start of an episode.
        record: Keep observations.
        record_gripper: Keep one observation per tick of finger motion, not only the last.
        on_frame: Called with every observation kept.
        omit: What to leave out.

    Attributes:
        frames: Observations kept so far.
        legs: The legs run so far.
        waypoint: The waypoint that is being visited; None before the first.
    """

    def __init__(
        self,
        runtime: Runtime,
        *,
        record: bool = True,
        record_gripper: bool = False,
        on_frame: Callable[[Observation], None] | None = None,
        omit: Omission = Omission(),
    ) -> None:
        self.runtime, self.record, self.record_gripper, self.on_frame = runtime, record, record_gripper, on_frame
        self.omit = omit
        self.frames: list[Observation] = []
        self.legs: list[LegReport] = []
        self.waypoint: Waypoint | None = None
        self._planner = LegPlanner(runtime)
        self._amount = 1.0
        self._target = runtime.robot.joint_positions
        self._succeeded = False
        self._ignores_collisions: bool | None = None

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
        for _ in range(MAX_ROUNDS):
            self._succeeded = False
            for waypoint, rest, turns in self._legs():
                if waypoint.index not in self.omit.waypoints:
                    self._run_leg(waypoint, rest, turns)
            repeat = task.should_repeat_waypoints()
            if self._succeeded or not repeat:
                break
        self._wait_for_success()
        return self.frames

    def _legs(self) -> Iterator[tuple[Waypoint, list[Waypoint], list[float]]]:
        """Yield each waypoint that is not skipped, those after it in its run, and the turns of the hand to try, best first.

        Start hooks run here, before the poses of their leg are read.
        """
        for run in runs(self.runtime.task.get_waypoints()):
            turns: list[float] | None = None
            for number, waypoint in enumerate(run, start=1):
                self.waypoint = waypoint
                waypoint.run_start_hook()
                if waypoint.skip:
                    continue
                if turns is None:
                    turns = self._planner.rank(run)
                yield waypoint, run[number:], turns
                turns = [self._planner.turn]

    def _run_leg(self, waypoint: Waypoint, rest: Sequence[Waypoint], turns: Sequence[float]) -> None:
        self._succeeded = False
        plan = self._plan(waypoint, rest, turns)
        self.runtime.listeners.segment(waypoint, plan)
        self._ignores_collisions = waypoint.ignore_collisions
        if len(self.frames) == 1:
            self._flag(self.frames[0])
        follow(self.runtime, plan.trajectory, on_tick=self._arm_tick)
        if waypoint.gripper is not None and (waypoint.releases or not self.omit.grasps):
            self._operate_gripper(waypoint)
        waypoint.run_end_hook()

    def _plan(self, waypoint: Waypoint, rest: Sequence[Waypoint], turns: Sequence[float]) -> Plan:
        began = time.process_time()
        plan = self._planner.plan(waypoint, rest, turns)
        seconds = time.process_time() - began
        self.legs.append(LegReport(waypoint.index, plan.report.method, seconds, plan.trajectory.duration))
        return plan

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
        self._check()

    def _gripper_tick(self) -> None:
        self._check()
        if self.record_gripper:
            self._frame()

    def _check(self) -> None:
        """Note success; raise when the fail list ends the episode."""
        success, terminate = self.runtime.task.success()
        if terminate and not success:
            raise DemoError("The fail list of the task was met.", self.runtime.task)
        self._succeeded = self._succeeded or success

    def _wait_for_success(self) -> None:
        """Hold until the goal is reached, but never for two ticks alone: the last frame is a key frame, as is the one before."""
        self._check()
        for ticks in range(EXTRA_TICKS):
            if self._succeeded and ticks != 2:
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
            self._flag(observation)
        self.frames.append(observation)
        if self.on_frame is not None:
            self.on_frame(observation)

    def _flag(self, observation: Observation) -> None:
        """Note on a frame how the leg that it belongs to was planned; the first frame belongs to the first leg."""
        if self.runtime.observer.config.record_ignore_collisions:
            observation.ignore_collisions = self._ignores_collisions


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
