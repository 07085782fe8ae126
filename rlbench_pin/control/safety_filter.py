"""A filter in front of any policy: the joint velocity nearest to the wanted one that breaks no limit and touches nothing.

At configuration q the filter passes on the next velocity u that solves

    minimise    ||(u - u_wanted) / v_max||^2
    subject to  u_min <= u <= u_max                       joint limits, braking distance included (`constraints`)
                grad d_k (q) u >= - gain (d_k - d_min)    for near pairs k: velocity dampers                       (1)

where d_k are distances between the arm, what it holds and the world, and their gradients come from nearest points and
normals (`robot.distances`). With (1) a distance d approaches its minimum d_min exponentially (Faverjon & Tournassoud
1987; a control barrier function of the class d' >= -gain d). When no row is active, u is the wanted velocity clipped to
the box, and no QP is solved.

(1) is linear in a short motion and leaves out braking, so the result is checked: the tick of u and the hardest
braking after it, at true distances and in all pairs (`braking`), and within the motors' torques (`motors`). If that way
is not clear, commands between u and braking are tried, and last braking itself, which was checked one tick ago. Therefore,
in a world that stands still, limits hold and distances stay above the minimum at all times, also when the QP is
infeasible: braking is the safe stop.

A state that breaks a rule already is led back: joints beyond their limits brake, then return; pairs nearer than the
minimum may not come nearer, and (1) asks them to separate at most at `recovery_speed`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.control.braking import BrakingCheck
from rlbench_pin.control.checks import as_state, as_vector, check_made_of
from rlbench_pin.control.motors import MotorCheck
from rlbench_pin.control.qp.constraints import JointBounds
from rlbench_pin.control.qp.dampers import ROWS, Dampers
from rlbench_pin.control.qp.osqp_solver import OsqpSolver
from rlbench_pin.control.qp.quadratic_program import QPSolver, QuadraticProgram
from rlbench_pin.control.safety_records import FilterCounts, Reason, SafeCommand, SafetyConfig
from rlbench_pin.errors import InfeasibleControl
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.limits import JointLimits
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.motion_bounds import IndexArray
from rlbench_pin.spatial import FloatArray

BETWEEN = (0.5,)
"""Shares of the QP's solution, the rest braking, that are tried before braking itself when the way is not clear."""
DEFAULT = SafetyConfig()
NO_PAIRS: IndexArray = np.zeros(0, dtype=np.intp)


class SafetyFilter:
    """Makes joint velocities safe for one arm. Not thread-safe; a command depends on state, world and wanted velocity alone."""

    def __init__(
        self,
        model: RobotModel,
        config: SafetyConfig = DEFAULT,
        *,
        limits: JointLimits | None = None,
        solver: QPSolver | None = None,
        counts: FilterCounts | None = None,
    ) -> None:
        """Prepare a filter for an empty world; `distances.update` gives it the world.

        Args:
            model: The arm.
            config: Settings.
            limits: Joint limits; None takes the arm's.
            solver: Solves the QP; None is OSQP.
            counts: Where to count, which several filters may share; None is a new one.
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
        return self._dampers.nothing_near(np.array(turns))

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
        """Return the velocity in the box nearest to `wanted` that keeps the dampers, why it differs, and because of which pairs.

        The last are the smallest distances that braking has to keep, shape (pairs,), [m].
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
        """Return the first of `command`, commands between it and braking, and braking, whose way to standstill is clear.

        With it the pairs that refused `command`, whether motors did, and whether braking is all that was left.
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
        """Whether motors are too weak for the way of `command` to standstill."""
        if self._motors is None:
            return False
        self._motors.carry(self.distances.payload)
        return self._motors.overloaded(q, v, command)
