"""The quadratic program of all controllers, the interface of solvers, and OSQP.

minimise    1/2 x^T P x + q^T x
subject to  lower <= A x <= upper,   x_lower <= x <= x_upper
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import osqp
import scipy.sparse as sp

from rlbench_pin.errors import InfeasibleControl, InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import LARGEST_COUNT, as_array, as_finite, as_number, as_record, as_vector, as_whole

_FLOAT = np.dtype(float)
LARGEST = 1e100
"""Upper bound of unknowns; the squares of larger ones are infinite, or nearly so."""
_BOUNDS = ("lower", "upper", "x_lower", "x_upper")


@dataclass(frozen=True, eq=False, slots=True)
class QuadraticProgram:
    """A strictly convex problem in n unknowns with m rows and bounds. Infinite bounds are allowed."""

    P: FloatArray
    """Symmetric positive definite matrix (n, n)."""
    q: FloatArray
    """Linear cost (n,)."""
    A: FloatArray
    """Rows (m, n); m may be 0."""
    lower: FloatArray
    """Smallest values of the rows (m,)."""
    upper: FloatArray
    """Largest values of the rows (m,)."""
    x_lower: FloatArray
    """Smallest values of the unknowns (n,)."""
    x_upper: FloatArray
    """Largest values of the unknowns (n,)."""

    def __post_init__(self) -> None:
        """Raise InvalidValue unless the shapes match, cost and rows are finite, and no bound is NaN."""
        n, m = np.shape(as_array(self.q, "q")), np.shape(as_array(self.lower, "lower"))
        for name in ("q", "x_lower", "x_upper"):
            self._keep(name, n[:1])
        for name in ("lower", "upper"):
            self._keep(name, m[:1])
        self._keep("P", (*n[:1], *n[:1]))
        self._keep("A", (*m[:1], *n[:1]))

    def _keep(self, name: str, shape: tuple[int, ...]) -> None:
        """Check one array; the square of its norm is a fast test for NaN and infinity."""
        value, may_be_infinite = getattr(self, name), name in _BOUNDS
        if type(value) is np.ndarray and value.dtype is _FLOAT and value.shape == shape:
            square = float(np.vdot(value, value))
            if square < math.inf or (may_be_infinite and square == math.inf):
                return
        array = as_array(value, name)
        if array.shape != shape or not shape:
            raise InvalidValue(name, value, f"has to have shape {shape}, not {array.shape}")
        as_finite(np.where(np.isinf(array), 0.0, array) if may_be_infinite else array, name)
        object.__setattr__(self, name, array)

    def cost(self, x: FloatArray) -> float:
        """Return the objective at `x`."""
        x = as_vector(x, len(self.q), "x", most=LARGEST)
        return float(0.5 * x @ self.P @ x + self.q @ x)

    def violation(self, x: FloatArray) -> float:
        """Return the largest violation of a constraint by `x`; 0 if there is none."""
        x = as_vector(x, len(self.q), "x", most=LARGEST)
        rows = self.A @ x
        parts = (self.lower - rows, rows - self.upper, self.x_lower - x, x - self.x_upper)
        return max(0.0, *(float(part.max()) for part in parts if part.size))


class QPSolver(Protocol):
    """Solves one quadratic program at a time. A solution depends only on the problem, not on earlier problems."""

    def solve(self, problem: QuadraticProgram) -> FloatArray:
        """Return the minimiser (n,).

        Raises:
            InfeasibleControl: No point satisfies the constraints, or the solver did not converge.
        """
        ...


def empty_rows(n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return A, lower, upper of a problem in n unknowns without rows."""
    return np.empty((0, n)), np.empty(0), np.empty(0)


INFINITE = 1e30
"""Value that OSQP treats as no bound."""
FIXED = {"verbose": False, "adaptive_rho": False, "scaling": 0, "polishing": False, "time_limit": 1e10, "check_termination": 10}
"""Settings of all problems in this package, for reproducible results of OSQP."""


class OsqpSolver:
    """Solves strictly convex problems of up to `rows` rows, with the same solution of a problem in any process.

    The workspace is built for the first problem and reused.

    OSQP splits the problem (ADMM): each iteration solves one linear system and clips, with a step size rho. The number of
    iterations depends on scaling. So unknowns are scaled by typical magnitudes D, the cost by its trace c, rows
    by their length s:

        x = D y,    P' = D P D / c,    q' = D q / c,    c = trace(D P D),    a_i' = D a_i / s_i,    s_i = |D a_i|

    Rho is fixed, so that neither timing nor history has an effect; each solve starts from zero; there is no time limit.
    Directions whose curvature is far below rho converge slowly: a smaller rho is better for them, a
    larger one for active constraints. Stellato et al., "OSQP: an operator splitting solver for quadratic programs", 2020.
    """

    def __init__(
        self,
        scale: FloatArray | float = 1.0,
        rows: int = 0,
        *,
        rho: float = 0.1,
        tolerance: float = 1e-9,
        iterations: int = 20_000,
    ) -> None:
        """Set size, scaling and accuracy.

        Args:
            scale: Typical magnitude of the unknowns, one number or shape (n,).
            rows: Maximum number of rows of a problem.
            rho: Step size of the scaled problem, fixed.
            tolerance: Residual of the scaled problem below which it is solved.
            iterations: Maximum number of iterations.
        """
        self.scale = as_finite(as_array(scale, "scale"), "scale")
        if self.scale.ndim > 1 or not self.scale.size or self.scale.min() <= 0.0:
            raise InvalidValue("scale", scale, "has to be numbers > 0, one, or of shape (n,)")
        self.rows = as_whole(rows, "rows", least=0, most=1_000_000)
        as_number(rho, "rho", above=0.0)
        as_number(tolerance, "tolerance", above=0.0)
        as_whole(iterations, "iterations", least=1, most=LARGEST_COUNT)
        self.settings = FIXED | {
            "warm_starting": False,
            "rho": rho,
            "eps_abs": tolerance,
            "eps_rel": tolerance,
            "max_iter": iterations,
        }
        self.iterations = 0
        """Number of iterations of the last solve."""
        self._size = 0

    def solve(self, problem: QuadraticProgram) -> FloatArray:
        """Return the minimiser (n,).

        Raises:
            InfeasibleControl: No point satisfies the constraints, or the iterations do not converge.
        """
        as_record(problem, QuadraticProgram, "problem")
        n, m = len(problem.q), len(problem.lower)
        if m > self.rows:
            raise InvalidValue("problem.lower", problem.lower, f"has {m} rows; this solver accepts up to {self.rows} rows")
        if n != self._size:
            self._setup(n)
        D, low, high = self._D, self._low, self._high
        cost = problem.P * D[:, None] * D
        rows = problem.A * D
        length = np.sqrt(np.einsum("ij,ij->i", rows, rows)) + 1e-12
        unit = np.trace(cost)
        self._rows[n : n + m], self._rows[n + m :] = rows / length[:, None], 0.0
        low[:n], low[n : n + m], low[n + m :] = problem.x_lower / D, problem.lower / length, -INFINITE
        high[:n], high[n : n + m], high[n + m :] = problem.x_upper / D, problem.upper / length, INFINITE
        self._osqp.update(q=problem.q * D / unit, l=low, u=high, Px=cost[self._triangle] / unit, Ax=self._rows.ravel(order="F"))
        return np.minimum(np.maximum(D * self._run(problem), problem.x_lower), problem.x_upper)

    def _run(self, problem: QuadraticProgram) -> FloatArray:
        result = self._osqp.solve(raise_error=False)
        self.iterations = int(result.info.iter)
        if result.info.status_val != osqp.SolverStatus.OSQP_SOLVED:
            raise InfeasibleControl("OSQP", str(result.info.status), problem)
        return np.asarray(result.x)

    def _setup(self, n: int) -> None:
        """Build the dense workspace for n unknowns."""
        self._size, self._D = n, np.broadcast_to(self.scale, n).copy()
        self._rows = np.concatenate([np.eye(n), np.zeros((self.rows, n))])
        columns, rows = np.tril_indices(n)  # the upper triangle, column by column
        self._triangle = (rows, columns)
        self._low, self._high = np.full(n + self.rows, -INFINITE), np.full(n + self.rows, INFINITE)
        cost, pattern = sp.csc_matrix(np.triu(np.ones((n, n)))), sp.csc_matrix(np.ones((n + self.rows, n)))
        cost.data[:], pattern.data[:] = np.eye(n)[self._triangle], self._rows.ravel(order="F")
        self._osqp = osqp.OSQP()
        self._osqp.setup(cost, np.zeros(n), pattern, self._low, self._high, **self.settings)
