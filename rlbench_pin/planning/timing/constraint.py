"""The limits of a motion as TOPPRA wants them: velocity and acceleration of the joints, and speed along the arc with its change.

With the path q(s), u = d2s/dt2 and x = (ds/dt)^2 joint accelerations are q' u + q'' x, and the change of the arc's speed is
as `arc` says; all are rows a u + b x between bounds, asked for at each grid point, and for the end of the step that
begins there (x + 2 width u) as well.
"""

from __future__ import annotations

import numpy as np
import toppra
import toppra.constraint

from rlbench_pin.planning.timing.arc import ArcLimits
from rlbench_pin.robot.model import JointLimits
from rlbench_pin.spatial import FloatArray

_TINY = 1e-12
_FASTEST = 1e8
"""Bound of (ds/dt)^2 where nothing moves."""


class MotionConstraint(toppra.constraint.LinearConstraint):
    """A share of the limits, all in one, so that the path is evaluated once."""

    def __init__(self, limits: JointLimits, arc: ArcLimits | None, share: float) -> None:
        """Prepare the bounds.

        Args:
            limits: Velocity [rad/s] and acceleration [rad/s^2] bounds of each joint.
            arc: Limits along the joint-space arc; None for none.
            share: Share of all of them that may be used.
        """
        super().__init__()
        self.identical, self.dof = True, len(limits.velocity)
        self._arc, self._share = arc, share
        self._velocity = share * limits.velocity
        most = share * limits.acceleration
        bounds = np.concatenate([most, most] if arc is None else [most, [share * arc.acceleration]] * 2)
        self._sides = np.concatenate([np.eye(len(bounds)), -np.eye(len(bounds))])
        self._bounds = np.concatenate([bounds, bounds])

    def compute_constraint_params(
        self, path: toppra.interpolator.AbstractGeometricPath, gridpoints: FloatArray
    ) -> tuple[FloatArray | None, ...]:
        """Return a, b, c, F, g, bounds of u and bounds of x: F (a u + b x + c) <= g."""
        a, b = path(gridpoints, 1), path(gridpoints, 2)
        fastest = np.min((self._velocity / np.maximum(np.abs(a), _TINY)) ** 2, axis=1)
        if self._arc is not None:
            rates = np.maximum(np.linalg.norm(a, axis=1), _TINY)
            bends = (a * b).sum(axis=1) / rates
            fastest = np.minimum(fastest, (self._share * self._arc.velocity / rates) ** 2)
            a, b = np.column_stack([a, rates]), np.column_stack([b, bends])
        ends, bends_there = np.concatenate([a[1:], a[-1:]]), np.concatenate([b[1:], b[-1:]])
        widths = np.append(np.diff(gridpoints), 0.0)[:, None]
        u = np.concatenate([a, ends + 2.0 * widths * bends_there], axis=1)
        x = np.concatenate([b, bends_there], axis=1)
        between = np.stack([np.zeros_like(fastest), np.minimum(fastest, _FASTEST)], axis=1)
        return u, x, np.zeros_like(u), self._sides, self._bounds, None, between
