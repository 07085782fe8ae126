"""The quadratic program of `differential_ik`, written out as matrices: a cross-check, and the interface for other solvers.

With rows J = (J_p, J_r) along world axes, weights W = diag(w_p, w_p, w_p, w_r, w_r, w_r), and the symbols of `differential_ik`,

    P = J^T W J + w I,    q = -J^T W e - w_0 g (q_p - q),    dt u_min <= d <= dt u_max.

e is the tip's displacement of this tick: a difference of positions, and the rotation vector of R_target R_tip^T, both
along world axes.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from rlbench_pin.control.checks import as_state
from rlbench_pin.control.differential_ik import DifferentialIKConfig, Target, TipController
from rlbench_pin.control.qp.osqp_solver import OsqpSolver
from rlbench_pin.control.qp.quadratic_program import QPSolver, QuadraticProgram, empty_rows
from rlbench_pin.errors import InvalidValue
from rlbench_pin.robot.limits import JointLimits
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray


class DifferentialIKQP(TipController):
    """Tip pose or twist to joint velocity, like `DifferentialIK`, by any `QPSolver`."""

    def __init__(
        self,
        model: RobotModel,
        config: DifferentialIKConfig = DifferentialIKConfig(),  # noqa: B008 - frozen
        *,
        solver: QPSolver | None = None,
        limits: JointLimits | None = None,
        posture: FloatArray | None = None,
    ) -> None:
        """Prepare a controller; arguments as for `TipController`, and the solver, by default OSQP."""
        super().__init__(model, config, limits=limits, posture=posture)
        self.solver: QPSolver = OsqpSolver(config.dt * self.bounds.velocity, rho=1e-3) if solver is None else solver
        self._weights = np.repeat([config.tip.position_weight, config.tip.rotation_weight], 3)

    def problem(self, q: FloatArray, v: FloatArray, target: Target) -> QuadraticProgram:
        """Return the program whose solution is the displacement (n,), [rad], of the next tick."""
        q, v = as_state(q, v, self.model.size)
        if not callable(target):
            raise InvalidValue("target", target, "has to be a function: placement of the tip -> goal and longest step")
        now = self.model.tip_se3(q)
        goal, step = target(now)
        jacobian = self.model.jacobian(q)
        error = np.concatenate([goal.translation - now.translation, pin.log3(goal.rotation @ now.rotation.T)])
        posture = self.config.posture
        pull = posture.weight * min(1.0, posture.gain * self.config.dt)
        damping = posture.damping(self._manipulability(jacobian), step)
        weighted = jacobian.T * self._weights
        P = weighted @ jacobian + damping * np.eye(self.model.size)
        linear = -weighted @ error - pull * (self.posture - q)
        lowest, highest = self.bounds.displacements(q, v)
        return QuadraticProgram(P, linear, *empty_rows(self.model.size), np.array(lowest), np.array(highest))

    def _velocity(self, q: FloatArray, v: FloatArray, target: Target) -> FloatArray:
        step = self.solver.solve(self.problem(q, v, target))
        return step / self.config.dt
