"""Input and output of planning: settings, plan, report, and the time of each stage."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Literal, get_args

from rlbench_pin.errors import InvalidValue
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import FLAG, NOT_NEGATIVE, POSITIVE, as_number, check_settings, counted, ruled

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
    (FLAG, "torque_limits certify measure_clearance"),
)


@dataclass(frozen=True, kw_only=True)
class PlannerConfig:
    """How motions are searched and how fast they may be."""

    max_velocity: float = 1.0
    """Largest norm of the joint velocity, so that no joint is faster either [rad/s]."""
    max_acceleration: float = 4.0
    """Largest change of that norm, and largest acceleration of a joint [rad/s^2]."""
    torque_limits: bool = True
    """Keep the joint torques within their limits, with the bodies that the gripper holds."""
    jerk_time: float = 0.0
    """How long a change of acceleration takes at least [s]; 0 lets it jump."""
    margin: float = 0.003
    """Clearance to the world, except where start or goal have less [m]."""
    algorithm: Algorithm = "rrt_connect"
    """Sampling planner."""
    checks: int = 50_000
    """Budget of state checks of the sampling planner."""
    simplify_checks: int = 1000
    """Budget of state checks for shortcuts."""
    ik_starts: int = 40
    """Descents per goal pose at most."""
    branches: int = 4
    """Goal configurations that are planned to at most."""
    elbows: int = 0
    """Further goal configurations, on each side of the nearest, that hold the pose with the elbow elsewhere."""
    region_samples: int = 12
    """Poses that are drawn from a region of goals."""
    edge_step: float = 0.05
    """Resolution of edge checks while searching [rad]."""
    check_step: float = 0.02
    """Resolution of the check of the final path [rad]."""
    certify: bool = True
    """Accept a path only when it is certified free between its samples, too."""
    certify_checks: int = 6000
    """Budget of state checks of one continuous check."""
    clearance: float = 0.0
    """Clearance that paths around obstacles keep if they can, at most tried before `margin` [m]."""
    measure_clearance: bool = False
    """Report the clearance of every plan; costs some milliseconds."""
    own_margin: float = 0.001
    """Clearance between links of the arm [m]."""
    attempts: int = 3
    """Searches, ever finer, before giving up."""

    def __post_init__(self) -> None:
        """Refuse values that cannot work.

        Raises:
            InvalidValue: A number is NaN, of a wrong kind, or outside its range (also a ValueError).
        """
        if not isinstance(self.algorithm, str) or self.algorithm not in ALGORITHMS:
            raise InvalidValue("PlannerConfig.algorithm", self.algorithm, f"is one of {', '.join(ALGORITHMS)}")
        check_settings(self, _RULES)


@dataclass(frozen=True, kw_only=True)
class PlanReport:
    """How a plan came about."""

    method: Method
    """straight: a line of the tip; direct: a line in joint space; sampled: around obstacles; curve: through given poses."""
    goal: int
    """Index of the pose that was reached."""
    length: float
    """Length in joint space [rad]."""
    checks: int
    """Configurations checked for collisions."""
    seconds: dict[str, float]
    """Time spent in each stage [s]: rules, straight, ik, search, shorten, smooth, retime."""
    clearance: float | None = None
    """Smallest distance to anything that counts [m]; None when it was not measured."""
    certified: bool = False
    """Proven free of collisions as a continuum."""
    doubts: int = 0
    """Paths that were dropped because they could not be certified."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A motion ready to be executed."""

    trajectory: Trajectory
    """The timed motion."""
    path: FloatArray
    """Configurations along the way (m, n), [rad]."""
    report: PlanReport
    """How it came about."""


@dataclass(eq=False)
class Stages:
    """Measures how long each stage takes."""

    seconds: dict[str, float] = field(default_factory=dict)
    """Stage -> time spent in it [s]."""
    checks: int = 0
    """Collision checks that the model had counted before."""
    plan: Plan | None = None
    """What came of it; None while planning, and when it fails."""

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time until the block ends to stage `name`."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin
