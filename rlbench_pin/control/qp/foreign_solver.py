"""Any solver of `qpsolvers` (daqp, quadprog, proxqp, ...) as a `QPSolver`. Needs the `bench` extra."""

from __future__ import annotations

import numpy as np

from rlbench_pin.control.qp.programs import QuadraticProgram
from rlbench_pin.errors import InfeasibleControl, MissingExtra, UnknownName
from rlbench_pin.spatial import FloatArray

try:
    import qpsolvers
except ModuleNotFoundError as _error:
    raise MissingExtra("ForeignSolver", "qpsolvers", "bench") from _error


class ForeignSolver:
    """Solves quadratic programs through `qpsolvers.solve_qp`."""

    def __init__(self, name: str) -> None:
        """Select a solver by its name in `qpsolvers`."""
        if name not in qpsolvers.available_solvers:
            raise UnknownName("QP solver", name, qpsolvers.available_solvers)
        self.name = name

    def solve(self, problem: QuadraticProgram) -> FloatArray:
        """Return the minimiser (n,).

        Raises:
            InfeasibleControl: The solver found no solution.
        """
        rows = np.concatenate([problem.A, -problem.A])
        bounds = np.concatenate([problem.upper, -problem.lower])
        finite = np.isfinite(bounds)
        inequalities = (rows[finite], bounds[finite]) if finite.any() else (None, None)
        G, h = inequalities
        x = qpsolvers.solve_qp(problem.P, problem.q, G, h, lb=problem.x_lower, ub=problem.x_upper, solver=self.name)
        if x is None:
            raise InfeasibleControl(self.name, "no solution", problem)
        return np.asarray(x, dtype=float)
