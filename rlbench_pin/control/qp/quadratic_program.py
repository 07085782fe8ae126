"""The quadratic program that every controller here solves, and the interface of solvers.

minimise    1/2 x^T P x + q^T x
subject to  lower <= A x <= upper,   x_lower <= x <= x_upper
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rlbench_pin.spatial import FloatArray


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

    def cost(self, x: FloatArray) -> float:
        """Return the objective at `x`."""
        return float(0.5 * x @ self.P @ x + self.q @ x)

    def violation(self, x: FloatArray) -> float:
        """Return by how much `x` breaks the worst constraint; 0 when it keeps all."""
        rows = self.A @ x
        parts = (self.lower - rows, rows - self.upper, self.x_lower - x, x - self.x_upper)
        return max(0.0, *(float(part.max()) for part in parts if part.size))


class QPSolver(Protocol):
    """Solves one quadratic program at a time. A solution depends on the problem alone, never on the problems before."""

    def solve(self, problem: QuadraticProgram) -> FloatArray:
        """Return the minimiser (n,).

        Raises:
            InfeasibleControl: No point satisfies the constraints, or the solver did not converge.
        """
        ...


def empty_rows(n: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return A, lower, upper of a problem in n unknowns without rows."""
    return np.empty((0, n)), np.empty(0), np.empty(0)
