"""A safety filter for any policy: the joint velocity nearest to the desired one that keeps all limits and minimum distances.

At configuration q the filter returns the next velocity u that solves

    minimise    ||(u - u_wanted) / v_max||^2
    subject to  u_min <= u <= u_max                       joint limits, braking distance included (`constraints`)
                grad d_k (q) u >= - gain (d_k - d_min)    for near pairs k: velocity dampers                       (1)

where d_k are distances between the arm, held objects and the world, and their gradients come from nearest points and
normals (`robot.distances`). With (1) a distance d approaches its minimum d_min exponentially (Faverjon & Tournassoud
1987; a control barrier function of the class d' >= -gain d). If no row is active, u is the desired velocity clipped to
the box, and no QP is solved.

(1) is a linearisation and omits braking, so the result is checked: the tick of u and the hardest braking after it, with
exact distances of all pairs (`braking`), and within the motor torques. If that path is not clear, the filter tries commands
between u and braking, and finally braking itself, which was checked one tick ago. Therefore, in a stationary world, limits
hold and distances stay above the minimum at all times, also if the QP is infeasible: braking is the safe stop.

The filter recovers from states that already violate a rule: joints beyond their limits brake, then return; pairs nearer
than the minimum may not come nearer, and (1) separates them at most at `recovery_speed`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rlbench_pin.control.braking import BrakingCheck, MotorCheck
from rlbench_pin.control.checks import as_state, as_vector, check_made_of
from rlbench_pin.control.qp.constraints import HELD_QUANTITIES, HeldQuantity, JointBounds
from rlbench_pin.control.qp.programs import OsqpSolver, QPSolver, QuadraticProgram
from rlbench_pin.errors import InfeasibleControl, InvalidValue
from rlbench_pin.robot.distances import DistanceModel, IndexArray
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import NOT_NEGATIVE, POSITIVE, as_record, check_settings, counted, one_of, ruled

Reason = Literal["limits", "distance", "braking", "torque", "infeasible"]
"""Reasons for changing a command: joint limits; velocity dampers; a path to standstill that is not clear, or needs more torque
than the motors have; a QP without a solution."""

_RULES = ruled(
    (POSITIVE, "dt gain"),
    (NOT_NEGATIVE, "margin self_margin buffer influence recovery_speed limit_margin"),
    (one_of(*HELD_QUANTITIES), "hold"),
)


def _reasons(value: object, what: str) -> object:
    """Check reason -> count."""
    if not isinstance(value, dict) or not set(value) <= set(get_args(Reason)):
        problem = f"has to map reasons ({', '.join(get_args(Reason))}) to counts"
        raise InvalidValue(what, value, problem, "Omit it to start from zero.")
    for reason, count in value.items():
        counted(0)(count, f"{what}['{reason}']")
    return value


_COUNT_RULES = ruled((counted(0), "ticks interventions solves stops"), (_reasons, "reasons"))


@dataclass(frozen=True, kw_only=True)
class SafetyConfig:
    """Settings of the safety filter."""

    dt: float = 0.05
    """Control tick [s]."""
    hold: HeldQuantity = "velocity"
    """Time at which a commanded velocity is reached: at the start of the tick, linearly until its end, or any time in it."""
    margin: float = 0.01
    """Minimum distance to the world [m]."""
    self_margin: float = 0.005
    """Minimum distance between parts of the arm and held objects [m]."""
    buffer: float = 0.003
    """Distance above the minimum at which the dampers reach zero speed, to allow for curvature [m]."""
    gain: float = 5.0
    """Fraction of the distance above the minimum that may be lost per second [1/s]."""
    influence: float = 0.05
    """Distance below which pairs always take part in the QP [m]."""
    recovery_speed: float = 0.05
    """Maximum separation speed of pairs below the minimum [m/s]."""
    limit_margin: float = 0.0
    """Distance kept from the joint position limits [rad]."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, of a wrong kind, or outside its range (also a ValueError)."""
        check_settings(self, _RULES)


@dataclass(frozen=True, eq=False, slots=True)
class SafeCommand:
    """Command of the filter, and the reasons for a change."""

    velocity: FloatArray
    """Joint velocity of the next tick (n,), [rad/s]."""
    wanted: FloatArray
    """Desired joint velocity (n,), [rad/s]."""
    reasons: tuple[Reason, ...]
    """Reasons for the change; empty if the desired velocity is unchanged."""
    pairs: tuple[tuple[str, str], ...]
    """Names of the pairs that would come too near."""
    stopped: bool
    """Whether the command is the hardest braking, because no other safe command was found."""

    @property
    def intervened(self) -> bool:
        """Whether the command differs from the desired one."""
        return bool(self.reasons)

    def __str__(self) -> str:
        """Return the reasons as text."""
        near = ", ".join(f"{a} near {b}" for a, b in self.pairs)
        return f"{' and '.join(self.reasons) or 'passed'}{f' ({near})' if near else ''}{', braking' if self.stopped else ''}"


@dataclass
class FilterCounts:
    """Counts of the interventions of a filter."""

    ticks: int = 0
    """Total number of commands."""
    interventions: int = 0
    """Number of changed commands."""
    solves: int = 0
    """Number of solved QPs."""
    stops: int = 0
    """Number of commands that were the hardest braking."""
    reasons: dict[str, int] = field(default_factory=dict)
    """Reason -> number of commands changed for this reason."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a count that is not an integer, or an unknown reason (also a ValueError)."""
        check_settings(self, _COUNT_RULES)

    def add(self, command: SafeCommand) -> None:
        """Count one command."""
        as_record(command, SafeCommand, "command")
        self.ticks += 1
        self.interventions += command.intervened
        self.stops += command.stopped
        for reason in command.reasons:
            self.reasons[reason] = self.reasons.get(reason, 0) + 1


ROWS = 32
"""Maximum number of pairs in the QP; those nearest to violating a damper come first."""
SLACK = 1e-5
"""Tolerated decrease of the distance of a pair below the minimum [m]."""


@dataclass(frozen=True, eq=False, slots=True)
class DamperRows:
    """Rows `gradients` u >= `least` of a quadratic program."""

    which: IndexArray
    """Indices of the pairs, shape (m,)."""
    gradients: FloatArray
    """Gradients of their distances, shape (m, n), [m/rad]."""
    least: FloatArray
    """Minimum rates of change, shape (m,), [m/s]."""


class Dampers:
    """The dampers of one arm in its world.

    Args:
        distances: Distance model of the arm.
        config: Settings of the filter.
    """

    def __init__(self, distances: DistanceModel, config: SafetyConfig) -> None:
        self.distances, self.config = distances, config
        self._counts: NDArray[np.bool_] | None = None
        self._minimum = self._onset = np.zeros(0)

    def floors(self) -> FloatArray:
        """Return the minimum distances, shape (pairs,), [m]; minus infinity for ignored pairs."""
        model = self.distances
        if self._counts is not model.counts:
            self._counts = model.counts
            minimum = np.where(model.crosses, self.config.margin, self.config.self_margin)
            self._minimum = np.where(model.counts, minimum, -np.inf)
            self._onset = self._minimum + self.config.buffer
        return self._minimum

    def lowered(self) -> FloatArray:
        """Return the floors, lowered for pairs that are already below theirs."""
        model, floors = self.distances, self.floors()
        which = (model.bounds < floors).nonzero()[0]  # perhaps, or for sure: bounds are exact where it matters
        if len(which):
            floors = floors.copy()
            floors[which] = np.minimum(floors[which], model.measure(which) - SLACK)
        return floors

    def is_clear(self, turns: FloatArray) -> bool:
        """Return whether all pairs stay beyond the range of the dampers for joint motions up to `turns` (n,) [rad]."""
        model = self.distances
        self.floors()
        limit = model.motion.approach(turns)
        limit += self._onset
        near = (model.bounds < limit).nonzero()[0]  # perhaps
        return all(model.distance(k) >= least for k, least in zip(near.tolist(), limit.take(near).tolist()))

    def rows(self, speeds: FloatArray) -> DamperRows:
        """Return rows for pairs that are near, or may violate a damper if joints move at up to `speeds` (n,) [rad/s]."""
        model = self.distances
        self.floors()
        config, onset = self.config, self._onset
        reach = np.maximum(model.motion.approach(speeds / config.gain), config.influence)
        near = (model.bounds - onset < reach).nonzero()[0]
        spare = model.measure(near) - onset[near]
        keep = spare < reach[near]
        near, spare = near[keep], spare[keep]
        if len(near) > ROWS:
            first = np.argsort(spare - np.minimum(reach[near], 1.0 / config.gain), kind="stable")[:ROWS]
            near, spare = near[first], spare[first]
        return DamperRows(near, model.gradients(near), np.minimum(-config.gain * spare, config.recovery_speed))


BETWEEN = (0.5,)
"""Fractions of the QP's solution, blended with braking, to try before full braking if the path is not clear."""
DEFAULT = SafetyConfig()
NO_PAIRS: IndexArray = np.zeros(0, dtype=np.intp)


class SafetyFilter:
    """Filters joint velocities of one arm. Not thread-safe; a command depends only on state, world and desired velocity."""

    def __init__(
        self,
        model: RobotModel,
        config: SafetyConfig = DEFAULT,
        *,
        limits: JointLimits | None = None,
        solver: QPSolver | None = None,
        counts: FilterCounts | None = None,
    ) -> None:
        """Prepare a filter for an empty world; `distances.update` sets the world.

        Args:
            model: The arm.
            config: Settings.
            limits: Joint limits; None takes the arm's.
            solver: Solves the QP; None is OSQP.
            counts: Counts to update, which several filters may share; None creates new ones.
        """
        check_made_of(model, config, SafetyConfig)
        self.model, self.config = model, config
        self.bounds = JointBounds(model.limits if limits is None else limits, config.dt, config.hold, config.limit_margin)
        self.distances = DistanceModel(model)
        self.counts = FilterCounts() if counts is None else counts
        self._dampers = Dampers(self.distances, config)
        self._braking = BrakingCheck(self.distances, self.bounds)
        self._motors = MotorCheck(model, self.bounds) if config.hold == "any" else None
        default = OsqpSolver(self.bounds.velocity, ROWS, rho=0.1, tolerance=1e-6, iterations=4000) if solver is None else solver
        self._solver: QPSolver = default
        self._weight = self.bounds.velocity**-2.0

    def filter(self, q: ArrayLike, v: ArrayLike, wanted: ArrayLike) -> SafeCommand:
        """Return the safe joint velocity of the next tick.

        Args:
            q: Configuration (n,), [rad].
            v: Joint velocity (n,) now, that is, the last command; [rad/s].
            wanted: Joint velocity (n,) as a policy asks for it, [rad/s].

        Raises:
            InvalidTarget: NaN or a wrong shape.
        """
        q, v = as_state(q, v, self.model.size)
        wanted = as_vector(wanted, self.model.size, "wanted joint velocity")
        self.distances.place(q)
        clipped, inside = self._clipped(q, v, wanted)
        reasons: tuple[Reason, ...] = () if inside else ("limits",)
        if self._clear(v, clipped) and not self._overloaded(q, v, clipped):
            result = SafeCommand(clipped, wanted.copy(), reasons, (), False)
        else:
            result = self._solved(q, v, clipped, wanted, reasons)
        self.counts.add(result)
        return result

    def filter_acceleration(self, q: ArrayLike, v: ArrayLike, wanted: ArrayLike) -> SafeCommand:
        """Like `filter` for a wanted joint acceleration (n,), [rad/s^2]; the command is the velocity at the end of the tick."""
        now, change = (
            as_vector(x, self.model.size, what) for x, what in ((v, "joint velocity"), (wanted, "wanted acceleration"))
        )
        return self.filter(q, now, now + self.config.dt * change)

    def _clipped(self, q: FloatArray, v: FloatArray, wanted: FloatArray) -> tuple[FloatArray, bool]:
        """Return the velocity (n,) in the box nearest to `wanted`, and whether that is `wanted` itself."""
        dt, asked = self.config.dt, wanted.tolist()
        box = zip(asked, *self.bounds.displacements(q, v))
        nearest = [low / dt if x < low / dt else high / dt if x > high / dt else x for x, low, high in box]
        return np.array(nearest), nearest == asked

    def _clear(self, v: FloatArray, command: FloatArray) -> bool:
        """Whether no damper can break and nothing is in reach of the way of `command` to standstill, by one bound for all."""
        travel = self.bounds.travels(v, command)
        left = 1.0 - sum(travel)  # levers grow with the motion
        if left < 0.5:  # a fast arm; the bound would be far off
            return False
        gain = self.config.gain
        turns = [max(abs(u) / gain, way / left) for u, way in zip(command.tolist(), travel)]
        return self._dampers.is_clear(np.array(turns))

    # Proposing ----------------------------------------------------------------------------------------------------

    def _solved(
        self, q: FloatArray, v: FloatArray, clipped: FloatArray, wanted: FloatArray, reasons: tuple[Reason, ...]
    ) -> SafeCommand:
        """Return the safe command nearest to `clipped`, near something; `reasons` say why that is not what was `wanted`."""
        command, changed, pairs, floors = self._damped(q, v, clipped)
        command, refused, weak, stopped = self._checked(q, v, command, floors)
        reasons = (*reasons, *changed, *(("braking",) if len(refused) else ()), *(("torque",) if weak else ()))
        names = tuple(dict.fromkeys(self.distances.names(k) for k in [*pairs.tolist(), *refused.tolist()]))
        return SafeCommand(command, wanted.copy(), reasons, names, stopped or "infeasible" in reasons)

    def _damped(
        self, q: FloatArray, v: FloatArray, wanted: FloatArray
    ) -> tuple[FloatArray, tuple[Reason, ...], IndexArray, FloatArray]:
        """Return the velocity in the box nearest to `wanted` that keeps the dampers, the reasons for a change, and the pairs.

        The last returned value is the minimum distances that braking has to keep, shape (pairs,), [m].
        """
        rows, floors = self._dampers.rows(np.abs(wanted)), self._dampers.lowered()
        which, gradients, least = rows.which, rows.gradients, rows.least
        if self.config.hold == "acceleration":  # the tick moves by the mean of both velocities
            gradients, least = 0.5 * gradients, least - 0.5 * gradients @ v
        slack = gradients @ wanted - least
        if slack.min(initial=0.0) >= 0.0:
            return wanted, (), NO_PAIRS, floors
        infinite = np.full(len(which), np.inf)
        lowest, highest = self.bounds.interval(q, v)
        problem = QuadraticProgram(np.diag(self._weight), -self._weight * wanted, gradients, least, infinite, lowest, highest)
        self.counts.solves += 1
        try:
            velocity = self._solver.solve(problem)
        except InfeasibleControl:
            return self.bounds.braking(v), ("infeasible",), which[slack < 0.0], floors
        return velocity, ("distance",), which[gradients @ velocity - least < 1e-4], floors

    # Checking -----------------------------------------------------------------------------------------------------

    def _checked(
        self, q: FloatArray, v: FloatArray, command: FloatArray, floors: FloatArray
    ) -> tuple[FloatArray, IndexArray, bool, bool]:
        """Return the first of `command`, commands between it and braking, and braking, whose path to standstill is clear.

        Also return the pairs that rejected `command`, whether the motors did, and whether only braking remained.
        """
        refused = self._braking.unsafe(q, v, command, floors)
        weak = not len(refused) and self._overloaded(q, v, command)
        if not len(refused) and not weak:
            return command, refused, weak, False
        brake = self.bounds.braking(v)
        for share in BETWEEN:
            between = brake + share * (command - brake)
            if not len(self._braking.unsafe(q, v, between, floors)) and not self._overloaded(q, v, between):
                return between, refused, weak, False
        return brake, refused, weak, True

    def _overloaded(self, q: FloatArray, v: FloatArray, command: FloatArray) -> bool:
        """Return whether the path of `command` to standstill exceeds the motor torques."""
        if self._motors is None:
            return False
        self._motors.carry(self.distances.payload)
        return self._motors.overloaded(q, v, command)
