"""The sparse program of `predictive`: matrices of a fixed pattern whose numbers are renewed in place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from rlbench_pin.control.qp.constraints import JointBounds
from rlbench_pin.spatial import FloatArray

IndexArray = NDArray[np.intp]
_FAR = 1e30
DISTANCE_UNIT = 30.0
"""Distance rows and slacks are measured in 1/30 m: their multipliers are like the others then, and one rho serves all."""


@dataclass(frozen=True)
class ProgramSize:
    """How large the program is."""

    joints: int
    """Number of joints n."""
    ticks: int
    """Ticks of the horizon."""
    pairs: int
    """Distance rows per tick."""

    @property
    def motion(self) -> int:
        """Number of velocities, and of deviations."""
        return self.joints * self.ticks

    @property
    def unknowns(self) -> int:
        """Velocities, deviations, and one slack per tick when there are distances."""
        return 2 * self.motion + (self.ticks if self.pairs else 0)


class PredictiveProgram:
    """Matrices `cost` and `rows`, vectors `linear`, `low`, `high`, in OSQP's form; unknowns are (u, x, s)."""

    def __init__(
        self, size: ProgramSize, bounds: JointBounds, change_weight: float, final_weight: float, slack_weight: float
    ) -> None:
        """Lay out the program.

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
        """Set all that depends on the state to zero, and the bounds free."""
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
        """Write what depends on the present state (n,) and the nominal configurations (N, n): bounds and dynamics."""
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
        """Lay out P: tridiagonal in the velocities, one full block per deviation, slightly convex in the slacks."""
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
        """Lay out A: bounds of all unknowns, dynamics, changes of velocity, distances."""
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
        """Return where the gradients of tick k are in the data of `rows`, shape (pairs, n)."""
        size, n = self.size, self.size.joints
        first_row, first_column = self._distances.start + k * size.pairs, size.motion + k * n
        i, j = rows.row - first_row, rows.col - first_column
        inside = (i >= 0) & (i < size.pairs) & (j >= 0) & (j < n)
        entries = np.empty((size.pairs, n), dtype=np.intp)
        entries[i[inside], j[inside]] = place[inside]
        return entries
