"""Impedance control: the arm acts as a spring and damper around a target, in joint or Cartesian space; the stiffness may change
at any tick.

Joint space:      tau = K (q_d - q) + D (v_d - v) + M a_d + h

Cartesian space:  tau = J^T (K e + D (x'_d - x')) + h + (I - J^T Jbar^T) tau_0,    Jbar = M^-1 J^T Lambda,   Lambda = (J
M^-1 J^T)^-1

with e the position error and the rotation vector of R_d R^T along world axes, and tau_0 a weak joint spring towards a
posture. The projector lets tau_0 do no work at the tip, so that at rest a force F moves the tip by K^-1 F.

Damping follows from stiffness and inertia: D = 2 zeta L sqrt(L^-1 K L^-T) L^T with L L^T the inertia (M or Lambda) makes
every mode of the coupled system have the damping ratio zeta (Albu-Schaeffer et al. 2003). It is recomputed at each tick,
so a change of stiffness keeps it.

Joint limits are not part of the spring. If its torques would move a joint so far, or so fast, that it could not stop in
time at its acceleration limit (`constraints`), their acceleration M^-1 (tau - h) is reduced to the largest one that allows
stopping. Otherwise the torques are not changed, so that the arm applies the full force of the spring.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike
from scipy.linalg import eigh

from rlbench_pin.control.checks import as_placement, as_state, as_vector, check_made_of
from rlbench_pin.control.qp.constraints import JointBounds
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array, as_number

SINGULAR = 1e-6
"""Term added to J M^-1 J^T; it bounds Lambda near singularities."""
TICK = 1.0 / 240.0
"""Default time for which torques are held [s]."""
LIMIT_MARGIN = 1e-3
"""Distance kept from joint position limits, for model errors [rad]."""


def damping_for(stiffness: FloatArray, inertia: FloatArray, ratio: float) -> FloatArray:
    """Return the damping matrix (m, m) that gives all modes of (inertia, stiffness), each (m, m), the damping ratio `ratio`."""
    squares, modes = eigh(stiffness, inertia)  # modes^T inertia modes = I, modes^T stiffness modes = diag(squares)
    back = inertia @ modes
    return (back * (2.0 * ratio * np.sqrt(np.maximum(squares, 0.0)))) @ back.T


def as_stiffness(value: ArrayLike, size: int) -> FloatArray:
    """Return a stiffness matrix (size, size) from one number, a diagonal (size,), or a matrix.

    Raises:
        InvalidTarget: It is not finite, not symmetric, or not positive semidefinite.
    """
    array = as_array(value, "stiffness", InvalidTarget)
    if array.shape not in ((), (size,), (size, size)):
        raise InvalidTarget("stiffness", value, f"has to be finite: a number, ({size},) or ({size}, {size})")
    matrix = array if array.ndim == 2 else np.diag(np.broadcast_to(array, size))
    if not np.isfinite(matrix).all():
        raise InvalidTarget("stiffness", value, f"has to be finite: a number, ({size},) or ({size}, {size})")
    if not np.allclose(matrix, matrix.T) or np.linalg.eigvalsh(matrix)[0] < 0.0:
        raise InvalidTarget("stiffness", value, "has to be symmetric and positive semidefinite")
    return matrix


class StopInTime:
    """Reduces torques that would move a joint past its position or velocity limit."""

    def __init__(self, model: RobotModel, dt: float) -> None:
        """Prepare for torques that are held for `dt` [s]."""
        self._model, self._bounds = model, JointBounds(model.limits, dt, "any", LIMIT_MARGIN, sudden=True)

    def __call__(self, q: FloatArray, v: FloatArray, tau: FloatArray) -> FloatArray:
        """Return torques (n,), [N m], within the effort limits: `tau` if the joints can stop after it, otherwise reduced."""
        model, bounds = self._model, self._bounds
        tau = np.clip(tau, -model.limits.effort, model.limits.effort)
        a = model.forward_dynamics(q, v, tau)
        lowest, highest = bounds.interval(q, v)
        least, most = np.minimum(lowest, v + bounds.step), np.maximum(highest, v - bounds.step)
        kept = np.minimum(np.maximum(a, (least - v) / bounds.dt), (most - v) / bounds.dt)
        if np.array_equal(kept, a):
            return tau
        return np.clip(model.inverse_dynamics(q, v, kept), -model.limits.effort, model.limits.effort)


class JointImpedance:
    """Joint impedance: a spring and damper between the arm and a configuration."""

    def __init__(self, model: RobotModel, stiffness: ArrayLike = 100.0, damping_ratio: float = 1.0, dt: float = TICK) -> None:
        """Set the stiffness [N m/rad] as a number, (n,) or (n, n), the damping ratio, and the time that torques are held [s]."""
        check_made_of(model)
        self.model, self.damping_ratio = model, as_number(damping_ratio, "damping_ratio", least=0.0)
        self.stiffness = stiffness
        self._stop_in_time = StopInTime(model, dt)

    @property
    def stiffness(self) -> FloatArray:
        """Stiffness matrix (n, n), [N m/rad]; may be set at any time."""
        return self._stiffness.copy()

    @stiffness.setter
    def stiffness(self, value: ArrayLike) -> None:
        """Set it from one number, a diagonal (n,), or a positive semidefinite matrix (n, n), [N m/rad]."""
        self._stiffness = as_stiffness(value, self.model.size)

    def torque(
        self,
        q: ArrayLike,
        v: ArrayLike,
        q_target: ArrayLike,
        v_target: ArrayLike | None = None,
        a_target: ArrayLike | None = None,
    ) -> FloatArray:
        """Return joint torques (n,), [N m], within the effort limits, after which joints can stop before their limits.

        Args:
            q: Configuration (n,), [rad].
            v: Joint velocity (n,), [rad/s].
            q_target: Target of the spring, (n,), [rad].
            v_target: Velocity of the target (n,), [rad/s]; None is rest.
            a_target: Its acceleration (n,), [rad/s^2]; None is 0.

        Raises:
            InvalidTarget: NaN or a wrong shape.
        """
        n, model = self.model.size, self.model
        q, v = as_state(q, v, n)
        error = as_vector(q_target, n, "target configuration") - q
        rate = (np.zeros(n) if v_target is None else as_vector(v_target, n, "target velocity")) - v
        a = np.zeros(n) if a_target is None else as_vector(a_target, n, "target acceleration")
        damping = damping_for(self._stiffness, model.mass_matrix(q), self.damping_ratio)
        return self._stop_in_time(q, v, self._stiffness @ error + damping @ rate + model.inverse_dynamics(q, v, a))


class CartesianImpedance:
    """Cartesian impedance: a spring and damper between the tip and a pose."""

    def __init__(
        self,
        model: RobotModel,
        stiffness: ArrayLike = (400.0, 400.0, 400.0, 30.0, 30.0, 30.0),
        damping_ratio: float = 1.0,
        posture_stiffness: float = 5.0,
        posture: FloatArray | None = None,
        dt: float = TICK,
    ) -> None:
        """Set the spring.

        Args:
            model: The arm.
            stiffness: One number, (6,) or (6, 6) along world axes, translation [N/m] first, then rotation [N m/rad].
            damping_ratio: Damping ratio of all modes.
            posture_stiffness: Stiffness of the joint spring in the null space [N m/rad].
            posture: Target of the joint spring (n,), [rad]; None uses the home configuration.
            dt: Time for which torques are held [s].
        """
        check_made_of(model)
        self.model, self.damping_ratio = model, as_number(damping_ratio, "damping_ratio", least=0.0)
        self.posture_stiffness = as_number(posture_stiffness, "posture_stiffness", least=0.0)
        self.posture = as_vector(model.home if posture is None else posture, model.size, "posture").copy()
        self.stiffness = stiffness
        self._stop_in_time = StopInTime(model, dt)

    @property
    def stiffness(self) -> FloatArray:
        """Stiffness matrix (6, 6) along world axes, [N/m, N m/rad]; may be set at any time."""
        return self._stiffness.copy()

    @stiffness.setter
    def stiffness(self, value: ArrayLike) -> None:
        """Set it from one number, a diagonal (6,), or a positive semidefinite matrix (6, 6), [N/m, N m/rad]."""
        self._stiffness = as_stiffness(value, 6)

    def torque(self, q: ArrayLike, v: ArrayLike, pose: ArrayLike, twist: ArrayLike | None = None) -> FloatArray:
        """Return joint torques (n,), [N m], within the effort limits, after which joints can stop before their limits.

        Args:
            q: Configuration (n,), [rad].
            v: Joint velocity (n,), [rad/s].
            pose: Target pose of the tip (7,) in the world.
            twist: Velocity of the target `[linear, angular]` (6,) along world axes; None is rest.

        Raises:
            InvalidTarget: NaN, a wrong shape, or a quaternion of norm zero.
        """
        model = self.model
        q, v = as_state(q, v, model.size)
        goal = as_placement(pose)
        target = np.zeros(6) if twist is None else as_vector(twist, 6, "twist")
        now, jacobian, mass = model.tip_se3(q), model.jacobian(q), model.mass_matrix(q)
        error = np.concatenate([goal.translation - now.translation, pin.log3(goal.rotation @ now.rotation.T)])
        mobility = np.linalg.solve(mass, jacobian.T)  # M^-1 J^T
        inertia = np.linalg.inv(jacobian @ mobility + SINGULAR * np.eye(6))
        damping = damping_for(self._stiffness, 0.5 * (inertia + inertia.T), self.damping_ratio)
        wrench = self._stiffness @ error + damping @ (target - jacobian @ v)
        spring = self._posture_torque(q, v, mass)
        spring -= jacobian.T @ (inertia @ (mobility.T @ spring))
        return self._stop_in_time(q, v, jacobian.T @ wrench + spring + model.inverse_dynamics(q, v, np.zeros(model.size)))

    def _posture_torque(self, q: FloatArray, v: FloatArray, mass: FloatArray) -> FloatArray:
        """Return the torque (n,) of the joint spring, critically damped in each joint."""
        return self.posture_stiffness * (self.posture - q) - 2.0 * np.sqrt(self.posture_stiffness * mass.diagonal()) * v
