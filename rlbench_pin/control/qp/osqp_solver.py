"""Small dense quadratic programs by OSQP, the same answer to the same problem in any process.

OSQP splits the problem (ADMM): each iteration solves one linear system and clips, with a step size rho. How many
iterations that takes depends on scaling. So unknowns are measured in typical magnitudes D, the cost in its trace c, rows
in their length s:

    x = D y,    P' = D P D / c,    q' = D q / c,    c = trace(D P D),    a_i' = D a_i / s_i,    s_i = |D a_i|

Rho stays fixed, so that neither timing nor history enters; every solve starts from zero; there is no time limit. Of the
directions that the cost hardly sees, those whose curvature is far below rho converge slowly: a smaller rho suits them, a
larger one suits active constraints. Stellato et al., "OSQP: an operator splitting solver for quadratic programs", 2020.
"""

from __future__ import annotations

import numpy as np
import osqp
import scipy.sparse as sp

from rlbench_pin.control.qp.quadratic_program import QuadraticProgram
from rlbench_pin.errors import InfeasibleControl, InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import LARGEST_COUNT, as_array, as_finite, as_number, as_record, as_whole

INFINITE = 1e30
"""OSQP takes this for no bound."""
FIXED = {"verbose": False, "adaptive_rho": False, "scaling": 0, "polishing": False, "time_limit": 1e10, "check_termination": 10}
"""Settings of every problem in this package: what makes OSQP repeat itself."""


class OsqpSolver:
    """Solves strictly convex problems of up to `rows` rows; the work space is built for the first one and kept."""

    def __init__(
        self,
        scale: FloatArray | float = 1.0,
        rows: int = 0,
        *,
        rho: float = 0.1,
        tolerance: float = 1e-9,
        iterations: int = 20_000,
    ) -> None:
        """Choose size, scaling and accuracy.

        Args:
            scale: Typical magnitude of the unknowns, one number or shape (n,).
            rows: Most rows that a problem will have.
            rho: Step size of the scaled problem, fixed.
            tolerance: Residual of the scaled problem that counts as solved.
            iterations: When to give up.
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
        """Iterations that the last solve took."""
        self._size = 0

    def solve(self, problem: QuadraticProgram) -> FloatArray:
        """Return the minimiser (n,).

        Raises:
            InfeasibleControl: No point satisfies the constraints, or the iterations do not converge.
        """
        as_record(problem, QuadraticProgram, "problem")
        n, m = len(problem.q), len(problem.lower)
        if m > self.rows:
            raise InvalidValue("problem.lower", problem.lower, f"has {m} rows; this solver takes up to {self.rows} rows")
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
        """Build the work space for n unknowns, all dense."""
        self._size, self._D = n, np.broadcast_to(self.scale, n).copy()
        self._rows = np.concatenate([np.eye(n), np.zeros((self.rows, n))])
        columns, rows = np.tril_indices(n)  # the upper triangle, column by column
        self._triangle = (rows, columns)
        self._low, self._high = np.full(n + self.rows, -INFINITE), np.full(n + self.rows, INFINITE)
        cost, pattern = sp.csc_matrix(np.triu(np.ones((n, n)))), sp.csc_matrix(np.ones((n + self.rows, n)))
        cost.data[:], pattern.data[:] = np.eye(n)[self._triangle], self._rows.ravel(order="F")
        self._osqp = osqp.OSQP()
        self._osqp.setup(cost, np.zeros(n), pattern, self._low, self._high, **self.settings)
