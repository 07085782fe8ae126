"""The quadratic program that every controller here solves, and the interface of solvers.

minimise    1/2 x^T P x + q^T x
subject to  lower <= A x <= upper,   x_lower <= x <= x_upper
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rlbench_pin.errors import InvalidValue
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array, as_finite, as_vector

_FLOAT = np.dtype(float)
LARGEST = 1e100
"""The square of a larger unknown is infinite, or nearly so."""
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
        """Raise InvalidValue unless the shapes fit together, cost and rows are finite, and no bound is NaN."""
        n, m = np.shape(as_array(self.q, "q")), np.shape(as_array(self.lower, "lower"))
        for name in ("q", "x_lower", "x_upper"):
            self._keep(name, n[:1])
        for name in ("lower", "upper"):
            self._keep(name, m[:1])
        self._keep("P", (*n[:1], *n[:1]))
        self._keep("A", (*m[:1], *n[:1]))

    def _keep(self, name: str, shape: tuple[int, ...]) -> None:
        """Check one array; the square of its length tells quickly whether something in it is NaN or infinite."""
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
        """Return by how much `x` breaks the worst constraint; 0 when it keeps all."""
        x = as_vector(x, len(self.q), "x", most=LARGEST)
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
