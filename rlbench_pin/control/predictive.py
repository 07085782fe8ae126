"""Model predictive control of the tip: optimise the joint velocities of the next half second, and command the first.

The unknowns are velocities u_0 .. u_{N-1}, deviations x_1 .. x_N of the configurations from a nominal motion, and slacks
s_1 .. s_N:

    minimise    sum_k  ||J_k x_k - e_k||_W^2 + w_c ||u_k - u_{k-1}||^2 + w_p ||qbar_k + x_k - q_p||^2
                       + w_s s_k + w_t ||u_{N-1}||^2
    subject to  qbar_{k+1} + x_{k+1} = qbar_k + x_k + dt u_k,    x_0 = 0
                |u_k| <= v_max,   |u_k - u_{k-1}| <= a dt,   u_0 in the interval of `constraints`
                lower <= qbar_k + x_k <= upper
                d_i(qbar_k) + grad d_i x_k + s_k >= d_min  for the nearest pairs i,   s_k >= 0

where e_k is the error from the tip at qbar_k to the reference pose k, and J_k the Jacobian there. The nominal motion
is the last plan, shifted by one tick: one linearisation per tick (Diehl's real-time iteration). The matrices are sparse
with a fixed pattern. OSQP starts from the last solution, so a command depends only on the commands since `reset`.

s_k keeps the QP feasible if distances cannot be kept; joint limits always can. If OSQP does not converge, the
command is braking. Distances are linearised, so use a `SafetyFilter` after this controller if they must be guaranteed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import osqp
import pinocchio as pin
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from rlbench_pin.control.checks import as_placement, as_state, as_vector, check_made_of
from rlbench_pin.control.qp.constraints import JointBounds
from rlbench_pin.control.qp.programs import FIXED
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.distances import DistanceModel
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import NOT_NEGATIVE, POSITIVE, as_array, check_settings, counted, ruled

IndexArray = NDArray[np.intp]
_FAR = 1e30
DISTANCE_UNIT = 30.0
"""Scale of distance rows and slacks (unit 1/30 m): their multipliers are then similar to the others, and one rho suffices."""


@dataclass(frozen=True)
class ProgramSize:
    """Dimensions of the program."""

    joints: int
    """Number of joints n."""
    ticks: int
    """Number of ticks of the horizon."""
    pairs: int
    """Number of distance rows per tick."""

    @property
    def motion(self) -> int:
        """Number of velocities, and of deviations."""
        return self.joints * self.ticks

    @property
    def unknowns(self) -> int:
        """Number of velocities, deviations, and slacks (one per tick with distances)."""
        return 2 * self.motion + (self.ticks if self.pairs else 0)


class PredictiveProgram:
    """Matrices `cost` and `rows`, vectors `linear`, `low`, `high`, in OSQP's form; unknowns are (u, x, s)."""

    def __init__(
        self, size: ProgramSize, bounds: JointBounds, change_weight: float, final_weight: float, slack_weight: float
    ) -> None:
        """Set up the program.

        Args:
            size: Its size.
            bounds: Joint limits and the tick.
            change_weight: Weight of changes of velocity.
            final_weight: Weight of the last velocity.
            slack_weight: Weight of 1 m of slack.
        """
        self.size, self.bounds = size, bounds
        self._change_weight = change_weight
        self.linear = np.zeros(size.unknowns)
        self.linear[2 * size.motion :] = slack_weight / DISTANCE_UNIT
        self._build_cost(final_weight)
        self._build_rows()
        self.clear()

    def clear(self) -> None:
        """Set all state-dependent entries to zero, and remove the bounds."""
        size = self.size
        for k in range(size.ticks):
            self.set_objective(k, np.eye(size.joints), np.zeros(size.joints))
            if size.pairs:
                self.set_distances(k, np.zeros((0, size.joints)), np.zeros(0))

    def split(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return velocities (N, n), deviations (N, n) and slacks (N,) or (0,)."""
        size = self.size
        shape = (size.ticks, size.joints)
        return (
            x[: size.motion].reshape(shape),
            x[size.motion : 2 * size.motion].reshape(shape),
            x[2 * size.motion :] / DISTANCE_UNIT,
        )

    # Numbers ------------------------------------------------------------------------------------------------------

    def set_state(self, q: FloatArray, v: FloatArray, nominal: FloatArray) -> None:
        """Write the bounds and dynamics for the present state (n,) and the nominal configurations (N, n)."""
        n, motion, limits = self.size.joints, self.size.motion, self.bounds.limits
        slowest, fastest = self.bounds.interval(q, v)
        self.low[:motion], self.high[:motion] = (
            np.tile(-limits.velocity, self.size.ticks),
            np.tile(limits.velocity, self.size.ticks),
        )
        self.low[:n], self.high[:n] = slowest, fastest
        self.low[motion : 2 * motion] = (limits.lower - nominal).ravel()
        self.high[motion : 2 * motion] = (limits.upper - nominal).ravel()
        defects = (np.concatenate([q[None], nominal[:-1]]) - nominal).ravel()
        self.low[self._dynamics] = self.high[self._dynamics] = defects
        self.linear[:n] = -2.0 * self._change_weight * v

    def set_objective(self, k: int, quadratic: FloatArray, linear: FloatArray) -> None:
        """Write the cost of deviation x_{k+1}: x^T quadratic x + 2 linear^T x."""
        n = self.size.joints
        start = self.size.motion + k * n
        self.cost.data[self._cost_blocks[k]] = 2.0 * quadratic[self._triangle]
        self.linear[start : start + n] = 2.0 * linear

    def set_distances(self, k: int, gradients: FloatArray, spare: FloatArray) -> None:
        """Write the rows of tick k+1: gradients (m, n) and distances above the minimum (m,), m at most `size.pairs`."""
        block = np.zeros((self.size.pairs, self.size.joints))
        block[: len(spare)] = DISTANCE_UNIT * gradients
        self.rows.data[self._distance_entries[k]] = block
        start = self._distances.start + k * self.size.pairs
        self.low[start : start + self.size.pairs] = -_FAR
        self.low[start : start + len(spare)] = -DISTANCE_UNIT * spare

    # Pattern ------------------------------------------------------------------------------------------------------

    def _build_cost(self, final_weight: float) -> None:
        """Set up P: tridiagonal in the velocities, one full block per deviation, slightly convex in the slacks."""
        size, n = self.size, self.size.joints
        steps = 2.0 * np.eye(size.ticks) - np.eye(size.ticks, k=1) - np.eye(size.ticks, k=-1)
        steps[-1, -1] = 1.0
        velocities = np.kron(2.0 * self._change_weight * steps, np.eye(n))
        velocities[-n:, -n:] += 2.0 * final_weight * np.eye(n)
        blocks = sp.block_diag([np.ones((n, n))] * size.ticks)
        slacks = sp.eye(size.unknowns - 2 * size.motion) / DISTANCE_UNIT**2
        self.cost = sp.triu(sp.block_diag([sp.csc_matrix(velocities), blocks, slacks]), format="csc")
        columns, rows = np.tril_indices(n)
        self._triangle = (rows, columns)
        count = len(rows)
        first = int(self.cost.indptr[size.motion])
        self._cost_blocks = [slice(first + k * count, first + (k + 1) * count) for k in range(size.ticks)]

    def _build_rows(self) -> None:
        """Set up A: bounds of all unknowns, dynamics, changes of velocity, distances."""
        size, dt = self.size, self.bounds.dt
        n, ticks, motion = size.joints, size.ticks, size.motion
        move = sp.eye(motion) - sp.eye(motion, k=-n)  # x_{k+1} - x_k, and u_k - u_{k-1}
        slacks = size.unknowns - 2 * motion
        none = sp.csc_matrix((motion, slacks))
        dynamics = sp.hstack([-dt * sp.eye(motion), move, none])
        changes = sp.hstack([move.tocsr()[n:], sp.csc_matrix((motion - n, motion + slacks))])
        parts = [sp.eye(size.unknowns), dynamics, changes]
        ends = np.cumsum([0, *(part.shape[0] for part in parts), ticks * size.pairs])
        self._dynamics, self._distances = slice(ends[1], ends[2]), slice(ends[3], ends[4])
        if size.pairs:
            blocks = sp.block_diag([np.ones((size.pairs, n))] * ticks)
            parts.append(
                sp.hstack([sp.csc_matrix((ticks * size.pairs, motion)), blocks, sp.kron(sp.eye(ticks), np.ones((size.pairs, 1)))])
            )
        rows = sp.vstack(parts).tocoo()
        order = sp.coo_matrix((np.arange(1, rows.nnz + 1), (rows.row, rows.col)), rows.shape).tocsc()
        self.rows = sp.csc_matrix(rows)
        place = np.empty(rows.nnz, dtype=np.intp)
        place[order.data - 1] = np.arange(rows.nnz)
        self._distance_entries = [self._block_entries(rows, place, k) for k in range(ticks)] if size.pairs else []
        self.low, self.high = np.full(rows.shape[0], -_FAR), np.full(rows.shape[0], _FAR)
        self.low[2 * motion : size.unknowns] = 0.0
        step = np.tile(self.bounds.step, ticks - 1)
        self.low[ends[2] : ends[3]], self.high[ends[2] : ends[3]] = -step, step

    def _block_entries(self, rows: sp.coo_matrix, place: IndexArray, k: int) -> IndexArray:
        """Return the positions of the gradients of tick k in the data of `rows`, shape (pairs, n)."""
        size, n = self.size, self.size.joints
        first_row, first_column = self._distances.start + k * size.pairs, size.motion + k * n
        i, j = rows.row - first_row, rows.col - first_column
        inside = (i >= 0) & (i < size.pairs) & (j >= 0) & (j < n)
        entries = np.empty((size.pairs, n), dtype=np.intp)
        entries[i[inside], j[inside]] = place[inside]
        return entries


_RULES = ruled(
    (POSITIVE, "dt tolerance"),
    (NOT_NEGATIVE, "position_weight rotation_weight change_weight posture_weight final_weight slack_weight margin self_margin"),
    (counted(1, 1000), "horizon"),
    (counted(0, 1000), "pairs"),
    (counted(1, 10_000_000), "iterations"),
)


@dataclass(frozen=True, kw_only=True)
class PredictiveConfig:
    """Settings of model predictive control."""

    dt: float = 0.05
    """Control tick [s]."""
    horizon: int = 10
    """N: number of ticks of the horizon."""
    position_weight: float = 100.0
    """Weight of 1 m^2."""
    rotation_weight: float = 10.0
    """Weight of 1 rad^2."""
    change_weight: float = 2e-2
    """w_c."""
    posture_weight: float = 1e-3
    """w_p."""
    final_weight: float = 1e-3
    """w_t."""
    slack_weight: float = 100.0
    """w_s: weight of 1 m of slack."""
    pairs: int = 6
    """Number of nearest pairs that are constrained at each tick of the horizon, if distances are given."""
    margin: float = 0.02
    """d_min to the world [m]."""
    self_margin: float = 0.01
    """d_min within the arm [m]."""
    tolerance: float = 1e-4
    """Residual below which OSQP stops."""
    iterations: int = 4000
    """Maximum number of iterations of OSQP."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, of a wrong kind, or outside its range (also a ValueError)."""
        check_settings(self, _RULES)


@dataclass(frozen=True, eq=False, slots=True)
class PredictiveCommand:
    """The next command and its plan."""

    velocity: FloatArray
    """Joint velocity of the next tick (n,), [rad/s]."""
    plan: FloatArray
    """Configurations planned for the next ticks (N, n), [rad]."""
    shortfall: float
    """Largest slack [m]: the largest violation of a minimum distance by the plan."""
    stopped: bool
    """Whether the command is braking, because the QP was not solved."""


class CartesianMPC:
    """Follows tip references by model predictive control. Not thread-safe."""

    def __init__(
        self,
        model: RobotModel,
        config: PredictiveConfig = PredictiveConfig(),
        *,
        distances: DistanceModel | None = None,
        limits: JointLimits | None = None,
        posture: FloatArray | None = None,
    ) -> None:
        """Prepare a controller.

        Args:
            model: The arm.
            config: Settings.
            distances: Distances to keep; None ignores distances.
            limits: Joint limits; None takes the arm's.
            posture: Preferred configuration (n,), [rad]; None takes the arm's home.
        """
        check_made_of(model, config, PredictiveConfig)
        self.model, self.config, self.distances = model, config, distances
        self.bounds = JointBounds(model.limits if limits is None else limits, config.dt)
        self.posture = as_vector(model.home if posture is None else posture, model.size, "posture").copy()
        size = ProgramSize(model.size, config.horizon, config.pairs if distances is not None else 0)
        self._program = PredictiveProgram(size, self.bounds, config.change_weight, config.final_weight, config.slack_weight)
        self._weights = np.repeat([config.position_weight, config.rotation_weight], 3)
        self._data = model.arm.createData()
        self.iterations = 0
        """Number of iterations of the last solve."""
        self.reset()

    def reset(self) -> None:
        """Forget the last plan."""
        self._plan: FloatArray | None = None
        settings = {
            "warm_starting": True,
            "rho": 0.1,
            "eps_abs": self.config.tolerance,
            "eps_rel": self.config.tolerance,
        }
        program = self._program
        program.clear()
        self._osqp = osqp.OSQP()
        cost, rows = program.cost, program.rows
        self._osqp.setup(
            cost, program.linear, rows, program.low, program.high, **FIXED, **settings, max_iter=self.config.iterations
        )

    def command(self, q: ArrayLike, v: ArrayLike, reference: ArrayLike) -> PredictiveCommand:
        """Return the joint velocity of the next tick, and the plan.

        Args:
            q: Configuration (n,), [rad].
            v: Joint velocity (n,) now, that is, the last command; [rad/s].
            reference: Tip pose (7,) to hold, or poses (N, 7) for the ends of the next ticks, in the world.

        Raises:
            InvalidTarget: NaN, a wrong shape, or a quaternion of norm zero.
        """
        q, v = as_state(q, v, self.model.size)
        goals = self._goals(reference)
        nominal = self._nominal(q, v)
        program = self._program
        program.set_state(q, v, nominal)
        for k, goal in enumerate(goals):
            program.set_objective(k, *self._objective(nominal[k], goal))
            if self.distances is not None:
                program.set_distances(k, *self._clearances(nominal[k]))
        if not np.isfinite(program.cost.data).all() or not np.isfinite(program.linear).all():
            return PredictiveCommand(self.bounds.braking(v), nominal, 0.0, True)
        self._osqp.update(q=program.linear, l=program.low, u=program.high, Px=program.cost.data, Ax=program.rows.data)
        result = self._osqp.solve(raise_error=False)
        self.iterations = int(result.info.iter)
        if result.info.status_val != osqp.SolverStatus.OSQP_SOLVED:
            self.reset()
            return PredictiveCommand(self.bounds.braking(v), nominal, 0.0, True)
        velocities, deviations, slacks = program.split(np.asarray(result.x))
        self._plan = velocities
        slowest, fastest = self.bounds.interval(q, v)
        velocity = np.minimum(np.maximum(velocities[0], slowest), fastest)
        return PredictiveCommand(velocity, nominal + deviations, float(slacks.max(initial=0.0)), False)

    def _goals(self, reference: ArrayLike) -> list[pin.SE3]:
        poses = as_array(reference, "reference", InvalidTarget)
        if poses.ndim == 1:
            return [as_placement(poses, "reference")] * self.config.horizon
        if poses.shape != (self.config.horizon, 7):
            raise InvalidTarget("reference", poses.shape, f"has to have shape (7,) or ({self.config.horizon}, 7)")
        return [as_placement(pose, "reference") for pose in poses]

    def _nominal(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the last plan from `q`, shifted by one tick; without a plan, braking. Shape (N, n), [rad]."""
        limits = self.bounds.limits
        if self._plan is None:
            velocities = np.zeros((self.config.horizon, len(q)))
            for row in velocities:
                v = self.bounds.braking(v)
                row[:] = v
        else:
            velocities = np.concatenate([self._plan[1:], self._plan[-1:]])
        return np.clip(q + self.config.dt * np.cumsum(velocities, axis=0), limits.lower, limits.upper)

    def _objective(self, q: FloatArray, goal: pin.SE3) -> tuple[FloatArray, FloatArray]:
        """Return the quadratic (n, n) and linear (n,) cost of the deviation from `q`."""
        jacobian = pin.computeFrameJacobian(self.model.arm, self._data, q, self.model.tip_id, pin.LOCAL_WORLD_ALIGNED)
        pin.forwardKinematics(self.model.arm, self._data, q)
        now = pin.updateFramePlacement(self.model.arm, self._data, self.model.tip_id)
        error = np.concatenate([goal.translation - now.translation, pin.log3(goal.rotation @ now.rotation.T)])
        weighted = jacobian.T * self._weights
        weight = self.config.posture_weight
        return weighted @ jacobian + weight * np.eye(len(q)), -weighted @ error - weight * (self.posture - q)

    def _clearances(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return gradients (m, n) of the nearest distances at `q`, and the distances above their minimum (m,), [m]."""
        model, config = self.distances, self.config
        assert model is not None
        model.place(q)
        least = np.where(model.crosses, config.margin, config.self_margin)
        hidden = np.where(model.counts, 0.0, np.inf)
        likely = np.argsort(model.bounds - least + hidden, kind="stable")[: 4 * config.pairs]
        spare = model.measure(likely) - least[likely] + hidden[likely]
        order = np.argsort(spare, kind="stable")[: config.pairs]
        which = likely[order][np.isfinite(spare[order])]
        return model.gradients(which), spare[order][: len(which)]
