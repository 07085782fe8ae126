"""The two passes of TOPP-RA (Pham, Pham 2018) over its own linear programs, without what its driver does around each of them.

With x = (ds/dt)^2 and u = d2s/dt2, x_(i+1) = x_i + 2 (s_(i+1) - s_i) u_i. Backwards, each grid point gets the range of x from
which the end can be reached at rest; forwards, x is chosen as large as that allows. The numbers are those of
`toppra.algorithm.TOPPRA`, to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import toppra
import toppra.constraint
from toppra.solverwrapper import seidelWrapper

from rlbench_pin.spatial import FloatArray

_NAN = math.nan
_TINY, _RETRIES = 1e-8, 10
_START = 1e-5
"""How much faster than 0 the slowest start (ds/dt)^2 may seem."""
_SLOWEST, _FASTEST = np.array([-1e-9, 1.0]), np.array([1e-9, -1.0])


def fastest_speeds(
    constraints: Sequence[toppra.constraint.Constraint],
    path: toppra.interpolator.AbstractGeometricPath,
    grid: FloatArray,
) -> FloatArray | None:
    """Return ds/dt (m,) at grid points (m,), at rest at both ends; None when the end cannot be reached at rest."""
    solver = seidelWrapper(list(constraints), path, grid, solve_lp1d=True)
    ranges = _ranges(solver, len(grid) - 1, _can_rest(solver))
    return None if ranges is None or ranges[0][0] > _START else _forward(solver, ranges)


def _can_rest(solver: seidelWrapper) -> bool:
    """Say whether u = x = 0 is within the constraints everywhere: F c <= g."""
    return all(c is None or (not c.any() and bool(np.all(g >= 0.0))) for _, _, c, _, g, _, _ in solver.params)


def _ranges(solver: seidelWrapper, steps: int, can_rest: bool) -> list[tuple[float, float]] | None:
    """Return the least and the largest x at each grid point from which the end can be reached at rest, or None."""
    solve, low, high = solver.solve_stagewise_optim, 0.0, 0.0
    ranges = [(low, high)]
    for i in range(steps - 1, -1, -1):
        largest = solve(i, None, _FASTEST, _NAN, _NAN, low, high)[1]
        least = 0.0 if can_rest else solve(i, None, _SLOWEST, _NAN, _NAN, low, high)[1]
        low, high = max(0.0, least), largest
        if math.isnan(least) or math.isnan(high):
            return None
        ranges.append((low, high))
    ranges.reverse()
    return ranges


def _forward(solver: seidelWrapper, ranges: list[tuple[float, float]]) -> FloatArray | None:
    """Return ds/dt (m,), as fast as the ranges of x allow; None when numbers fail."""
    solve, deltas, xs, tries, i = solver.solve_stagewise_optim, solver.get_deltas().tolist(), [0.0], 0, 0
    goals = np.array([[-2.0 * delta, -1.0] for delta in deltas])
    while i < len(deltas):
        x, (low, high) = xs[i], ranges[i + 1]
        u = solve(i, None, goals[i], x, x, low, high)[0]
        if math.isnan(u):
            if tries == _RETRIES:
                return None
            xs[i], tries = max(x - _TINY, 0.999 * x), tries + 1
            continue
        x, tries = x + 2.0 * deltas[i] * u, 0
        xs.append(min(high, max(low, max(x - _TINY, 0.9999 * x))))
        i += 1
    return np.sqrt(xs)
