"""Live demonstrations: plan and track the motion through the waypoints of a task, and record one observation per tick."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from rlbench_pin.environment.episode import EpisodeOrigin, checked_seed
from rlbench_pin.environment.runtime import Runtime, follow, move_gripper
from rlbench_pin.environment.waypoint_planning import WaypointPlanner, grasp_groups
from rlbench_pin.errors import (
    DemoError,
    InvalidArgument,
    NoWaypointsError,
    PlanningError,
    TaskEnvironmentError,
    WaypointError,
)
from rlbench_pin.observation import Demo, Observation, RandomState
from rlbench_pin.planning.plan import Plan
from rlbench_pin.spatial import FloatArray
from rlbench_pin.tasks import Task, Waypoint
from rlbench_pin.values import as_record

EXTRA_TICKS = 10
"""Maximum number of control ticks that a demonstration waits for success after its last segment."""
MAX_ROUNDS = 40
"""Maximum number of times that the waypoints of a task are visited."""


@dataclass(frozen=True, kw_only=True)
class Omission:
    """The part of a demonstration to leave out, to show that the demonstration fails without it."""

    waypoints: tuple[int, ...] = ()
    """Indices of the waypoints that are not visited."""
    grasps: bool = False
    """The gripper does not close on anything."""


@dataclass(frozen=True)
class SegmentReport:
    """One segment of a demonstration: the motion to a waypoint."""

    waypoint: int
    """Index of the waypoint at its end."""
    method: str
    """Planning method: straight, direct, sampled or curve."""
    planning_time: float
    """CPU time of planning in this process [s]."""
    duration: float
    """Duration of the motion [s]."""


@dataclass(frozen=True)
class DemoOutcome:
    """The result of one attempt at a demonstration."""

    success: bool
    """Whether the goal was reached."""
    cause: str
    """Cause of the failure; empty after a success."""
    waypoint: int | None
    """Waypoint at which it failed; None when it succeeded."""
    demo: Demo | None
    """The demonstration, None when it failed."""
    planning_time: float
    """CPU time of planning in this process [s]."""
    duration: float
    """Simulated time [s]."""
    segments: tuple[SegmentReport, ...] = field(default=())
    """The segments that were run."""


class DemoPlayer:
    """Plays one demonstration of the running task.

    Args:
        runtime: A task at the start of an episode.
        record: Keep observations.
        record_gripper: Keep one observation per tick of finger motion, not only the last.
        on_frame: Function that is called with each kept observation.
        omit: The part to leave out.

    Attributes:
        frames: Observations kept so far.
        segments: The segments run so far.
        waypoint: The target waypoint of the present segment; None before the first segment.
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
        self.segments: list[SegmentReport] = []
        self.waypoint: Waypoint | None = None
        self._planner = WaypointPlanner(runtime)
        self._amount = 1.0
        self._target = runtime.robot.joint_positions
        self._succeeded = False
        self._ignores_collisions: bool | None = None
        self._first = 0

    @property
    def planning_time(self) -> float:
        """CPU time of planning in this process so far [s]."""
        return sum(segment.planning_time for segment in self.segments)

    def play(self) -> list[Observation]:
        """Run the demonstration and return its observations.

        Raises:
            NoWaypointsError: The task has no waypoints.
            DemoError: The goal was not reached, or the fail list ended the episode.
            WaypointError: A waypoint is out of reach.
            PlanningError: A segment could not be planned.
        """
        task = self.runtime.task
        if not task.get_waypoints():
            raise NoWaypointsError(
                f"Task '{task.get_name()}' has no waypoints, so no demonstration can be planned. "
                "Add `[[waypoint]]` to its scene file.",
                task,
            )
        self._frame()
        for _ in range(MAX_ROUNDS):
            self._succeeded = False
            for waypoint, rest, angles in self._segments(task.get_waypoints()[self._first :]):
                if waypoint.index not in self.omit.waypoints:
                    self.run_segment(waypoint, rest, angles)
            self._first = 0
            repeat = task.should_repeat_waypoints()
            if self._succeeded or not repeat:
                break
        self._wait_for_success()
        return self.frames

    def _segments(self, waypoints: Sequence[Waypoint]) -> Iterator[tuple[Waypoint, list[Waypoint], list[float]]]:
        """Yield, for each waypoint that is not skipped, the waypoint, those after it in its group, and grasp angles, best first.

        Start hooks run here, before the poses of their segment are read.
        """
        for group in grasp_groups(waypoints):
            angles: list[float] | None = None
            for number, waypoint in enumerate(group, start=1):
                self.waypoint = waypoint
                waypoint.run_start_hook()
                if waypoint.skip:
                    continue
                if angles is None:
                    angles = self._planner.rank(group)
                yield waypoint, group[number:], angles
                angles = [self._planner.angle]

    def run_segment(self, waypoint: Waypoint, rest: Sequence[Waypoint], angles: Sequence[float]) -> None:
        """Plan and run the motion to a waypoint, execute its gripper command, and call its end hook.

        Args:
            waypoint: The waypoint.
            rest: The waypoints after it in its group.
            angles: Grasp angles to try, best first [rad].
        """
        self._succeeded = False
        self.move(waypoint, rest, self._plan(waypoint, rest, angles))
        if waypoint.gripper is not None and (waypoint.releases or not self.omit.grasps):
            self.operate_gripper(waypoint)
        waypoint.run_end_hook()

    def _plan(self, waypoint: Waypoint, rest: Sequence[Waypoint], angles: Sequence[float]) -> Plan:
        """Plan a motion from the present configuration to a waypoint, and report it as a segment."""
        began = time.process_time()
        plan = self._planner.plan(waypoint, rest, angles)
        seconds = time.process_time() - began
        self.segments.append(SegmentReport(waypoint.index, plan.report.method, seconds, plan.trajectory.duration))
        self.runtime.listeners.segment(waypoint, plan)
        self._ignores_collisions = waypoint.ignore_collisions
        if len(self.frames) == 1:
            self.flag(self.frames[0])
        return plan

    def move(self, waypoint: Waypoint, rest: Sequence[Waypoint], plan: Plan) -> None:
        """Execute the planned motion to a waypoint; `rest` contains the waypoints after it in its group."""
        follow(self.runtime, plan.trajectory, on_tick=self._arm_tick, compliant=waypoint.compliant)

    def operate_gripper(self, waypoint: Waypoint) -> None:
        """Execute the gripper command of a waypoint."""
        self._move_fingers(waypoint.gripper_amount, release=waypoint.releases)

    def _move_fingers(self, amount: float, *, release: bool) -> None:
        """Move the fingers to an opening fraction, then attach or release the object between them."""
        self._amount = amount
        move_gripper(
            self.runtime,
            amount,
            release=release,
            speed=self.runtime.description.grip_speed,
            attach=self.runtime.gripper.attaches,
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
        """Record success; raise DemoError if a condition of the fail list ends the episode."""
        success, terminate = self.runtime.task.success()
        if terminate and not success:
            raise DemoError("The fail list of the task was met.", self.runtime.task)
        self._succeeded = self._succeeded or success

    def _wait_for_success(self) -> None:
        """Hold the arm until the goal is reached, but never for exactly two ticks: the last two frames are key frames."""
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
            self.flag(observation)
        self.frames.append(observation)
        if self.on_frame is not None:
            self.on_frame(observation)

    def flag(self, observation: Observation) -> None:
        """Write the planning method of the segment into a frame; the first frame belongs to the first segment."""
        if self.runtime.observer.config.record_ignore_collisions:
            observation.ignore_collisions = self._ignores_collisions


def try_play(player: DemoPlayer) -> tuple[str, int | None]:
    """Play a demonstration; return the cause of its failure (empty on success) and the waypoint where it failed."""
    try:
        player.play()
    except (PlanningError, WaypointError, DemoError) as error:
        kind = error.reason if isinstance(error, PlanningError) else type(error).__name__
        return f"{kind}: {error}", None if player.waypoint is None else player.waypoint.index
    return "", None


LIBRARIES = ("rlbench_pin", "pin", "coal", "pybullet", "ompl", "toppra", "placo", "osqp", "numpy")
"""Python distributions whose version can change a demonstration."""


class LiveDemoFailed(DemoError, RuntimeError):
    """All attempts at a live demonstration failed; has the causes as attributes."""

    def __init__(self, task_name: str, seed: int, causes: list[str], task: object) -> None:
        self.seed, self.causes = seed, tuple(causes)
        text = "; ".join(f"attempt {i}: {cause}" for i, cause in enumerate(causes))
        super().__init__(
            f"Task '{task_name}' has no successful demonstration for seed {seed} in {len(causes)} attempts ({text}). "
            f"`rlbench-pin check {task_name}` shows the rate and the causes of such failures.",
            task,
        )


def play_demo(
    origin: EpisodeOrigin,
    player: DemoPlayer,
) -> DemoOutcome:
    """Play the demonstration of an episode that has just started, and return its result.

    Args:
        origin: Origin of the episode.
        player: Player of the demonstration.
    """
    runtime = player.runtime
    state, began = runtime.world.arrays(exact=False), runtime.world.time
    cause, waypoint = try_play(player)
    demo = None
    if not cause:
        demo = Demo(
            player.frames,
            random_seed=origin.seed,
            num_reset_attempts=origin.reset_attempts,
            variation_number=runtime.variation,
            instructions=origin.instructions,
            state=state,
            versions=library_versions(),
            attempt=origin.attempt,
            task_name=runtime.task.get_name(),
            robot=runtime.model.description.reference,
            joint_names=runtime.model.description.arm_joints,
            factors=origin.factors,
            task_version=runtime.world.spec.version,
        )
    duration = runtime.world.time - began
    return DemoOutcome(not cause, cause, waypoint, demo, player.planning_time, duration, tuple(player.segments))


def live_demos(play: Callable[[int, int], DemoOutcome], task: Task, seeds: Iterable[int], max_attempts: int) -> list[Demo]:
    """Return a demonstration for each seed.

    Args:
        play: Function of a seed and the number of the attempt that plays one attempt.
        task: The demonstrated task.
        seeds: Seeds of the episodes.
        max_attempts: Maximum number of attempts per seed.

    Raises:
        LiveDemoFailed: All attempts of a seed failed.
        TaskEnvironmentError: `max_attempts` is below 1.
    """
    if max_attempts < 1:
        raise TaskEnvironmentError(f"max_attempts={max_attempts} allows no attempt. Choose 1 or more.")
    demos: list[Demo] = []
    for seed in seeds:
        causes: list[str] = []
        for attempt in range(max_attempts):
            outcome = play(seed, attempt)
            if outcome.demo is not None:
                demos.append(outcome.demo)
                break
            causes.append(outcome.cause)
        else:
            raise LiveDemoFailed(task.get_name(), seed, causes, task)
    return demos


def check_start(demo: Demo, task_name: str, robot: str) -> int:
    """Return the seed from which a reset sets up the task of a demonstration.

    If the demonstration contains the state of a generator instead, its snapshot restores the world, and the seed is a hash
    of that state.

    Raises:
        TaskEnvironmentError: It has another task or another arm, no seed, or a generator state without a snapshot.
    """
    as_record(demo, Demo, "demo", InvalidArgument)
    if demo.task_name and demo.task_name != task_name:
        raise TaskEnvironmentError(
            f"The demonstration is of task '{demo.task_name}', but this environment runs '{task_name}'. "
            "Load that task with `get_task`."
        )
    if demo.robot not in ("", robot):
        raise TaskEnvironmentError(
            f"The demonstration was made with the arm '{demo.robot}', but this environment has '{robot}'. "
            f"Use Environment(robot_setup='{demo.robot}')."
        )
    if demo.random_seed is None:
        raise TaskEnvironmentError("The demonstration contains no seed, so its start cannot be restored. Record it again.")
    if not isinstance(demo.random_seed, tuple):
        return checked_seed(demo.random_seed)
    if demo.state is None:
        raise TaskEnvironmentError(
            "The demonstration contains the state of a random number generator instead of a seed, and no snapshot of the world: "
            "its start cannot be restored. Record it again."
        )
    return _seed_from(demo.random_seed)


def _seed_from(state: RandomState) -> int:
    """Return a seed derived from the state of a generator: a hash of it."""
    parts = b"".join(part.tobytes() if isinstance(part, np.ndarray) else repr(part).encode() for part in state)
    return int.from_bytes(hashlib.sha256(parts).digest()[:6], "big")


def restore_start(runtime: Runtime, demo: Demo) -> None:
    """Restore the exact start state of a demonstration from its snapshot, where its seed alone does not."""
    if demo.state is not None and not _same_arrays(runtime.world.arrays(exact=False), demo.state):
        runtime.world.set_arrays(demo.state)
        runtime.task.reset_conditions()


def _same_arrays(a: Mapping[str, np.ndarray], b: Mapping[str, np.ndarray]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(a[k], b[k]) for k in a)


def library_versions() -> dict[str, str]:
    """Return name -> version of this package and the libraries that shape a demonstration; `unknown` without metadata."""
    return {name: _version(name) for name in LIBRARIES} | {"pybullet": ", ".join(pybullet_distributions()) or "unknown"}


def pybullet_distributions() -> tuple[str, ...]:
    """Return the versions of the installed distributions of `pybullet`; the fork is named, `3.2.8 (pybullet-arm64)`."""
    found = {"": _version("pybullet"), " (pybullet-arm64)": _version("pybullet-arm64")}
    return tuple(number + name for name, number in found.items() if number != "unknown")


@cache
def _version(name: str) -> str:
    try:
        return version(name.replace("_", "-"))
    except PackageNotFoundError:  # a source tree that was never installed
        return "unknown"
