"""Settings, request, plan and report of one motion, and listeners of a planner."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Generic, Literal, TypeVar, get_args

from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.kinematics import PoseRegion
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.scene.snapshot import WorldSnapshot
from rlbench_pin.spatial import FloatArray, PoseLike
from rlbench_pin.values import (
    FLAG,
    NOT_NEGATIVE,
    POSITIVE,
    as_number,
    check_settings,
    counted,
    one_of,
    ruled,
)

Algorithm = Literal[
    "rrt_connect", "ompl_rrt_connect", "rrt", "rrt_star", "informed_rrt_star", "sorrt_star", "bit_star",
    "kpiece", "bkpiece", "lbkpiece",
]  # fmt: skip
ALGORITHMS: tuple[str, ...] = get_args(Algorithm)
Method = Literal["straight", "direct", "sampled", "curve"]
_RULES = ruled(
    (POSITIVE, "max_velocity max_acceleration"),
    (NOT_NEGATIVE, "jerk_time margin own_margin clearance"),
    (partial(as_number, least=1e-4), "edge_step check_step"),
    (counted(1), "checks ik_starts branches attempts certify_checks"),
    (counted(0), "simplify_checks"),
    (counted(0, 1000), "elbows"),
    (counted(1, 10_000), "region_samples"),
    (one_of(*ALGORITHMS), "algorithm"),
    (FLAG, "torque_limits certify measure_clearance"),
)


@dataclass(frozen=True, kw_only=True)
class PlannerConfig:
    """Settings of motion planning and timing."""

    max_velocity: float = 1.0
    """Largest norm of the joint velocity; it also bounds the velocity of each joint [rad/s]."""
    max_acceleration: float = 4.0
    """Largest rate of change of that norm, and largest acceleration of a joint [rad/s^2]."""
    torque_limits: bool = True
    """Keep the joint torques within their limits, including the load of held bodies."""
    jerk_time: float = 0.0
    """Minimum duration of a change of acceleration [s]; 0 allows jumps."""
    margin: float = 0.003
    """Minimum clearance to the world, except near a start or goal with less clearance [m]."""
    algorithm: Algorithm = "rrt_connect"
    """Sampling planner for paths around obstacles; straight and direct motions do not use it. RRT-Connect always replaces
    edges that fail the fine check."""
    checks: int = 50_000
    """Budget of state checks of the sampling planner."""
    simplify_checks: int = 1000
    """Budget of state checks for shortcuts."""
    ik_starts: int = 40
    """Maximum number of IK descents per goal pose."""
    branches: int = 4
    """Maximum number of goal configurations."""
    elbows: int = 0
    """Number of further goal configurations on each side of the nearest one, with another elbow position."""
    region_samples: int = 12
    """Number of poses that are drawn from a region of goals."""
    edge_step: float = 0.05
    """Resolution of edge checks during the search [rad]."""
    check_step: float = 0.02
    """Resolution of the check of the final path [rad]."""
    certify: bool = True
    """Accept a path only if it is certified free between its samples too."""
    certify_checks: int = 6000
    """Budget of state checks of one continuous check."""
    clearance: float = 0.0
    """Preferred clearance of paths around obstacles to the world, except near start and goals [m]. Without such a path, and for
    straight and direct motions, `margin` applies. A value up to `margin` has no effect."""
    measure_clearance: bool = False
    """Report the clearance of each plan; takes some milliseconds."""
    own_margin: float = 0.001
    """Minimum clearance between links of the arm [m]."""
    attempts: int = 3
    """Maximum number of searches, each finer than the previous one."""

    def __post_init__(self) -> None:
        """Reject invalid values.

        Raises:
            InvalidValue: A number is NaN, of a wrong kind, or outside its range (also a ValueError).
        """
        check_settings(self, _RULES)


@dataclass(frozen=True, kw_only=True)
class PlanReport:
    """Method, cost and checks of a plan."""

    method: Method
    """`straight`: a line of the tip; `direct`: a line in joint space; `sampled`: around obstacles; `curve`: through poses."""
    goal: int
    """Index of the reached goal pose."""
    length: float
    """Length in joint space [rad]."""
    checks: int
    """Number of configurations checked for collisions."""
    seconds: dict[str, float]
    """Time spent in each stage [s]: rules, straight, ik, search, shorten, smooth, retime."""
    clearance: float | None = None
    """Smallest distance to a forbidden contact [m]; None if it was not measured."""
    certified: bool = False
    """Whether the path is certified free of collisions between its samples too."""
    doubts: int = 0
    """Number of paths that were rejected because they could not be certified."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned motion."""

    trajectory: Trajectory
    """The timed motion."""
    path: FloatArray
    """Configurations along the path (m, n), [rad]."""
    report: PlanReport
    """Method, cost and checks of the plan."""


@dataclass(eq=False)
class Stages:
    """Measures the duration of each stage."""

    seconds: dict[str, float] = field(default_factory=dict)
    """Stage -> time spent in it [s]."""
    checks: int = 0
    """Number of collision checks of the model before this plan."""
    plan: Plan | None = None
    """The plan; None during planning and after a failure."""

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time until the block ends to stage `name`."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin


@dataclass(frozen=True, eq=False)
class PlanRequest:
    """Arguments of a planning call. Its arrays belong to the caller, so a listener that keeps one copies it."""

    kind: Literal["pose", "configuration", "curve"]
    """Kind of the call: `plan_to_pose`, `plan_to_configuration` or `plan_curve`."""
    q_start: FloatArray
    """Start configuration (n,), [rad]."""
    goal: PoseLike | Sequence[PoseLike] | PoseRegion
    """Tip poses (7,), one or several, or a region of them; for `configuration` joint positions (n,), [rad]."""
    ignore_collisions: bool
    """Whether collisions with the world are ignored."""
    allowed: tuple[str, ...]
    """Names of bodies that may be touched."""


class PlanningListener:
    """Receives the calls of a planner at their end. The methods do nothing: override those that you need."""

    def on_update(self, snapshot: WorldSnapshot, seconds: float) -> None:
        """Handle an update of the planner with the world.

        Args:
            snapshot: Snapshot of the world.
            seconds: Process time of the update [s].
        """

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """Handle a planned motion or its failure.

        Args:
            request: Arguments of the call.
            outcome: The plan, or the error that the caller gets.
            seconds: Process time of the planning [s].
        """

    def on_reach(self, seconds: float) -> None:
        """Handle a search for a configuration at a pose (without a motion) that took `seconds` [s] of process time."""


ListenerT = TypeVar("ListenerT", bound=PlanningListener)
Report = Callable[[ListenerT, float, BaseException | None], None]
"""Function that reports to one listener the process time of a block [s], and the error that ended it, or None."""


class ListenerList(Generic[ListenerT]):
    """Listeners, each for the duration of a block; without listeners no time is measured."""

    def __init__(self) -> None:
        self._listeners: list[ListenerT] = []

    @contextmanager
    def including(self, listener: ListenerT) -> Iterator[None]:
        """Add `listener` for the duration of a block."""
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    @contextmanager
    def timed(self, report: Report[ListenerT], errors: type[BaseException] | tuple[()] = ()) -> Iterator[None]:
        """Report a block when it ends.

        Args:
            report: Function that is called for each listener.
            errors: Errors that are reported too; a block that ends with another error is not reported.
        """
        if not self._listeners:
            yield
            return
        began = time.process_time()
        try:
            yield
        except errors as error:
            self._report(report, time.process_time() - began, error)
            raise
        self._report(report, time.process_time() - began, None)

    def _report(self, report: Report[ListenerT], seconds: float, error: BaseException | None) -> None:
        for listener in self._listeners:
            report(listener, seconds, error)


class PlanningListeners(ListenerList[PlanningListener]):
    """The listeners of one planner."""

    def update(self, snapshot: WorldSnapshot) -> AbstractContextManager[None]:
        """Report the block as one update."""
        return self.timed(lambda listener, seconds, _: listener.on_update(snapshot, seconds))

    @contextmanager
    def plan(self, request: PlanRequest, stages: Stages) -> Iterator[Stages]:
        """Report the block as one planned motion: `stages.plan`, or the error that it raises."""

        def report(listener: PlanningListener, seconds: float, error: BaseException | None) -> None:
            outcome = error if isinstance(error, PlanningError) else stages.plan
            assert outcome is not None
            listener.on_plan(request, outcome, seconds)

        with self.timed(report, PlanningError):
            yield stages

    def reach(self) -> AbstractContextManager[None]:
        """Report the block as one search for a configuration, found or not."""
        return self.timed(lambda listener, seconds, _: listener.on_reach(seconds), BaseException)
