"""Operational space control as a QP: the joint torques for a desired tip acceleration, within the limits of motors and joints.

With inertia M, Coriolis and gravity h, and tip Jacobian J, the torques are tau = M a + h, where the joint accelerations a solve

    minimise    ||W^1/2 (J a + dJ/dt v - x'')||^2 + w ||a - a_p||^2
    subject to  -tau_max <= M a + h <= tau_max
                 (u_min - v) / dt <= a <= (u_max - v) / dt

* x'' = x''_d + D (x'_d - x') + K e moves the tip to its target, with e the position error and the rotation vector of
  R_d R^T, both along world axes; K = omega^2 and D = 2 omega give critical damping. The term K e is bounded: a
  blocked arm presses with a bounded force, and approaches a far target at the speed at which the damping equals the bound.
* a_p = omega_p^2 (q_p - q) - 2 omega_p v keeps the null space near a posture; w is small, and adds damping near
  singularities.
* [u_min, u_max] is the interval of next velocities that keeps position, velocity and acceleration limits at all times
  (`constraints`).

Torque limits and the interval can contradict each other, for example with a heavy payload. Then the command is the safe stop:
brake each joint as hard as the motors allow. The method is from Khatib 1987, its formulation as a QP from Del Prete & Mansard
2015.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rlbench_pin.control.checks import as_placement, as_state, as_vector, check_made_of
from rlbench_pin.control.qp.constraints import JointBounds
from rlbench_pin.control.qp.programs import OsqpSolver, QPSolver, QuadraticProgram
from rlbench_pin.errors import InfeasibleControl
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import NOT_NEGATIVE, POSITIVE, check_settings, ruled

_RULES = ruled(
    (POSITIVE, "dt tip_frequency pull turning_pull rotation_weight"),
    (NOT_NEGATIVE, "posture_frequency posture_weight limit_margin"),
)


@dataclass(frozen=True, kw_only=True)
class OperationalSpaceConfig:
    """Settings of operational space control."""

    dt: float = 1.0 / 240.0
    """Time for which a torque is held [s]."""
    tip_frequency: float = 25.0
    """omega: decay rate of tip errors [rad/s]."""
    pull: float = 10.0
    """Largest acceleration that corrects a position error [m/s^2]."""
    turning_pull: float = 40.0
    """Largest acceleration that corrects a rotation error [rad/s^2]."""
    posture_frequency: float = 10.0
    """omega_p [rad/s]: the default is stiff enough that a contact at the tip does not swing the elbow."""
    rotation_weight: float = 0.1
    """Weight of 1 rad/s^2 at the tip; 1 m/s^2 weighs 1."""
    posture_weight: float = 1e-4
    """w."""
    limit_margin: float = 0.0
    """Distance kept from the joint position limits [rad]."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, of a wrong kind, or outside its range (also a ValueError)."""
        check_settings(self, _RULES)


@dataclass(frozen=True, eq=False, slots=True)
class TorqueCommand:
    """Torques for the next tick."""

    torque: FloatArray
    """Shape (n,), [N m], within the effort limits."""
    acceleration: FloatArray
    """Expected joint accelerations (n,), [rad/s^2]."""
    stopped: bool
    """Whether this is the safe stop, because no torque satisfies all constraints."""


class OperationalSpaceQP:
    """Computes joint torques for a tip pose, twist and acceleration. Not thread-safe."""

    def __init__(
        self,
        model: RobotModel,
        config: OperationalSpaceConfig = OperationalSpaceConfig(),
        *,
        limits: JointLimits | None = None,
        posture: FloatArray | None = None,
        solver: QPSolver | None = None,
    ) -> None:
        """Prepare a controller.

        Args:
            model: The arm, with its payload.
            config: Settings.
            limits: Joint limits; None takes the arm's.
            posture: Preferred configuration (n,), [rad]; None takes the arm's home.
            solver: Solves the QP; None is OSQP.
        """
        check_made_of(model, config, OperationalSpaceConfig)
        self.model, self.config = model, config
        self.limits = model.limits if limits is None else limits
        self.posture = as_vector(model.home if posture is None else posture, model.size, "posture").copy()
        self.bounds = JointBounds(self.limits, config.dt, "acceleration", config.limit_margin)
        default = OsqpSolver(self.limits.acceleration, model.size, rho=3e-3, tolerance=1e-7, iterations=10_000)
        self._solver: QPSolver = default if solver is None else solver
        self._weights = np.repeat([1.0, config.rotation_weight], 3)

    def command(
        self, q: ArrayLike, v: ArrayLike, pose: ArrayLike, twist: ArrayLike | None = None, acceleration: ArrayLike | None = None
    ) -> TorqueCommand:
        """Return the torques of the next tick.

        Args:
            q: Configuration (n,), [rad].
            v: Joint velocity (n,), [rad/s].
            pose: Tip target (7,) in the world.
            twist: Velocity of the target `[linear, angular]` (6,) along world axes, [m/s, rad/s]; None is rest.
            acceleration: Acceleration of the target (6,) along world axes, [m/s^2, rad/s^2]; None is 0.

        Raises:
            InvalidTarget: NaN, a wrong shape, or a quaternion of norm zero.
        """
        q, v = as_state(q, v, self.model.size)
        goal = as_placement(pose)
        target_twist = np.zeros(6) if twist is None else as_vector(twist, 6, "twist")
        target_acceleration = np.zeros(6) if acceleration is None else as_vector(acceleration, 6, "acceleration")
        problem, mass, bias = self._problem(q, v, goal, target_twist, target_acceleration)
        effort = self.limits.effort
        try:
            a, stopped = self._solver.solve(problem), False
        except InfeasibleControl:
            a, stopped = (self.bounds.braking(v) - v) / self.config.dt, True
        torque = np.minimum(np.maximum(mass @ a + bias, -effort), effort)
        return TorqueCommand(torque, a, stopped)

    def _problem(
        self, q: FloatArray, v: FloatArray, goal: pin.SE3, twist: FloatArray, acceleration: FloatArray
    ) -> tuple[QuadraticProgram, FloatArray, FloatArray]:
        """Return the program for the accelerations, the inertia and the bias torques."""
        model, data, tip, config = self.model.arm, self.model.data, self.model.tip_id, self.config
        mass = self.model.mass_matrix(q)
        bias = np.array(pin.nonLinearEffects(model, data, q, v))
        jacobian = self.model.jacobian(q)
        pin.forwardKinematics(model, data, q, v, np.zeros_like(v))
        now = pin.updateFramePlacement(model, data, tip)
        drift = pin.getFrameClassicalAcceleration(model, data, tip, pin.LOCAL_WORLD_ALIGNED).vector
        error = np.concatenate([goal.translation - now.translation, pin.log3(goal.rotation @ now.rotation.T)])
        omega, omega_p = config.tip_frequency, config.posture_frequency
        pull = omega * omega * error
        pull[:3] *= _shrink(pull[:3], config.pull)
        pull[3:] *= _shrink(pull[3:], config.turning_pull)
        wanted = acceleration + 2.0 * omega * (twist - jacobian @ v) + pull - drift
        rest = omega_p * omega_p * (self.posture - q) - 2.0 * omega_p * v
        weighted = jacobian.T * self._weights
        P = weighted @ jacobian + config.posture_weight * np.eye(len(q))
        slowest, fastest = self.bounds.interval(q, v)
        effort = self.limits.effort
        linear = -weighted @ wanted - config.posture_weight * rest
        low, high = (slowest - v) / config.dt, (fastest - v) / config.dt
        return QuadraticProgram(P, linear, mass, -effort - bias, effort - bias, low, high), mass, bias


def _shrink(vector: FloatArray, longest: float) -> float:
    """Return the factor that limits the length of a vector to `longest`."""
    length = float(np.linalg.norm(vector))
    return 1.0 if length <= longest else longest / length
