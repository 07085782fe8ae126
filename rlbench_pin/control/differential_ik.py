"""Differential inverse kinematics: compute the joint velocity of the next tick for a tip pose or twist, by one small QP.

At configuration q with tip Jacobian J, the displacement d = dt u of the next tick is the solution of

    minimise    w_p ||J_p d - e_p||^2 + w_r ||J_r d - e_r||^2 + (w - w_0 g) ||d||^2 + w_0 g ||d - (q_p - q)||^2
    subject to  dt u_min <= d <= dt u_max

* e = (e_p, e_r) is the desired displacement of the tip in this tick: dt times the twist, or the next step towards a
  pose. This step is short enough that the tip can stop at the pose (`qp.objectives`).
* The last two terms are damping and posture. Damping bounds ||d|| where J loses rank; the posture term moves the joints
  towards q_p in the null space. The weight w rises when the manipulability sqrt(det(J J^T)) falls (Nakamura & Hanafusa 1986)
  and the step is not small (Sugihara 2011). So the arm slows down along the lost direction and stays accurate in the others.
* [u_min, u_max] keeps position, velocity and acceleration limits, braking distance included (`qp.constraints`). The interval is
  never empty, so the QP is feasible in every state. From a state outside the limits, the command is the hardest braking or
  return.

`DifferentialIK` solves it with PlaCo. `DifferentialIKQP` states the same problem as plain matrices, for any solver; a test
compares the two. With rows J = (J_p, J_r) along world axes and weights W = diag(w_p, w_p, w_p, w_r, w_r, w_r),

    P = J^T W J + w I,    q = -J^T W e - w_0 g (q_p - q),    dt u_min <= d <= dt u_max.

Here e is the difference of positions and the rotation vector of R_target R_tip^T, both along world axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from operator import add
from struct import Struct
from typing import Literal

import numpy as np
import pinocchio as pin
import placo
from numpy.typing import ArrayLike

from rlbench_pin.control.checks import as_pose, as_state, as_vector, check_made_of
from rlbench_pin.control.qp.constraints import HELD_QUANTITIES, HeldQuantity, JointBounds
from rlbench_pin.control.qp.objectives import Manipulability, PostureObjective, TipApproach, TipObjective, moved
from rlbench_pin.control.qp.programs import OsqpSolver, QPSolver, QuadraticProgram, empty_rows
from rlbench_pin.errors import InfeasibleControl, InvalidValue, RobotModelError
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import kinematic_urdf
from rlbench_pin.values import NOT_NEGATIVE, POSITIVE, as_choice, check_settings, one_of, record_of, ruled

BASE = 7
"""Number of values of the base pose before the joints in the q of PlaCo."""
BASE_SPEED = 6
"""Number of values of the base twist before the joints in a displacement of PlaCo."""


class PlacoArm:
    """A PlaCo robot and kinematics solver for one arm, in the joint order of `RobotModel`."""

    def __init__(self, model: RobotModel) -> None:
        """Build the PlaCo robot and check that it is the arm of `model`.

        Raises:
            RobotModelError: PlaCo orders the joints differently, or its kinematics disagree with Pinocchio's.
        """
        self.size = model.size
        urdf = model.description.urdf
        text = kinematic_urdf(urdf, fixed=model.fingers.joints)
        self.robot = placo.RobotWrapper(urdf.name, int(placo.Flags.ignore_collisions), text)
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.mask_fbase(True)
        self.robot.set_T_world_fbase(model.base.homogeneous)
        self._state, self._pinocchio = self.robot.state, self.robot.model
        self._update, self._solve = self.robot.update_kinematics, self.solver.solve
        self._q = np.array(self._state.q)
        self._q_joints = self._q[BASE:]
        self._lower, self._upper = (
            memoryview(limit[BASE:]) for limit in (self._pinocchio.lowerPositionLimit, self._pinocchio.upperPositionLimit)
        )
        """Input of PlaCo."""
        self._write = Struct(f"{self.size}d").pack_into
        self._check(model)

    def set_configuration(self, q: FloatArray) -> None:
        """Put the arm at `q` (n,) [rad] and compute its kinematics."""
        self._q_joints[:] = q
        self._state.q = self._q
        self._update()

    def solve(self, q: Sequence[float], lowest: Sequence[float], highest: Sequence[float]) -> FloatArray:
        """Return the displacement (n,) [rad] of the next tick from `q`, between `lowest` and `highest` (lists of floats).

        PlaCo raises RuntimeError when there is no solution.
        """
        self._write(self._lower, 0, *map(add, q, lowest))
        self._write(self._upper, 0, *map(add, q, highest))
        return self._solve(False)[BASE_SPEED:]

    def _check(self, model: RobotModel) -> None:
        names = tuple(self.robot.joint_names())
        if names != model.description.arm_joints:
            raise RobotModelError(
                f"PlaCo orders the joints {names}, but the description has {model.description.arm_joints}. "
                "List `arm_joints` in the order of the URDF."
            )
        self.set_configuration(model.home)
        placo_tip = np.asarray(self.robot.get_T_world_frame(model.description.tip_frame))
        if not np.allclose(placo_tip, model.tip_se3(model.home).homogeneous, atol=1e-9):
            raise RobotModelError(
                f"PlaCo and Pinocchio compute different poses of '{model.description.tip_frame}' of '{model.description.name}'. "
                "Check the URDF of this arm."
            )


Target = Callable[[pin.SE3], tuple[pin.SE3, float]]
"""Current T_world_tip -> desired T_world_tip after the tick, and the larger of distance [m] and angle [rad] between them."""

_RULES = ruled(
    (POSITIVE, "dt"),
    (NOT_NEGATIVE, "limit_margin"),
    (record_of(TipObjective), "tip"),
    (record_of(PostureObjective), "posture"),
    (one_of(*HELD_QUANTITIES), "hold"),
)


@dataclass(frozen=True, kw_only=True)
class DifferentialIKConfig:
    """Settings of differential inverse kinematics."""

    dt: float = 0.05
    """Control tick [s]."""
    tip: TipObjective = field(default_factory=TipObjective)
    """Motion of the tip towards its goal."""
    posture: PostureObjective = field(default_factory=PostureObjective)
    """Motion of the arm in the null space of the tip."""
    limit_margin: float = 0.0
    """Distance kept from the joint position limits [rad]."""
    hold: HeldQuantity = "velocity"
    """Time at which the joints reach a velocity command: `velocity`: at the start of the tick; `acceleration`: linearly
    until its end; `any`: at any time in it."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, of a wrong kind, or outside its range (also a ValueError)."""
        check_settings(self, _RULES)


class TipController:
    """Base class of `DifferentialIK` and `DifferentialIKQP`: checks, bounds, and the next tip pose towards a target."""

    def __init__(
        self,
        model: RobotModel,
        config: DifferentialIKConfig = DifferentialIKConfig(),
        *,
        limits: JointLimits | None = None,
        posture: FloatArray | None = None,
    ) -> None:
        """Prepare a controller.

        Args:
            model: The arm.
            config: Settings.
            limits: Joint limits; None takes those of the arm.
            posture: Configuration (n,) that the null space is moved towards [rad]; None takes the home configuration of the arm.
        """
        check_made_of(model, config, DifferentialIKConfig)
        self.model, self.config = model, config
        self._approach = TipApproach(config.tip, config.dt)
        self._manipulability = Manipulability(model.size)
        self.bounds = JointBounds(model.limits if limits is None else limits, config.dt, config.hold, config.limit_margin)
        self.posture = as_vector(model.home if posture is None else posture, model.size, "posture").copy()

    def velocity_to_pose(self, q: ArrayLike, v: ArrayLike, pose: ArrayLike) -> FloatArray:
        """Return the joint velocity (n,), [rad/s], of the next tick towards a tip pose.

        Args:
            q: Current configuration (n,), [rad].
            v: Current joint velocity (n,), that is, the last command [rad/s].
            pose: Target pose of the tip in the world (7,): position [m], quaternion (x, y, z, w).

        Raises:
            InvalidTarget: NaN, a wrong shape, or a quaternion of norm zero.
        """
        q, v = as_state(q, v, self.model.size)
        goal = as_pose(pose)
        return self._velocity(q, v, lambda now: self._approach.next(now, goal))

    def velocity_for_twist(
        self, q: ArrayLike, v: ArrayLike, twist: ArrayLike, frame: Literal["world", "tip"] = "world"
    ) -> FloatArray:
        """Return the joint velocity (n,), [rad/s], of the next tick that gives the tip a twist.

        Args:
            q: Current configuration (n,), [rad].
            v: Current joint velocity (n,), that is, the last command [rad/s].
            twist: Velocity of the tip `[linear, angular]` (6,), [m/s, rad/s]. The tip speed is not capped.
            frame: Axes of the twist.

        Raises:
            InvalidTarget: NaN or a wrong shape.
        """
        q, v = as_state(q, v, self.model.size)
        as_choice(frame, "frame", ("world", "tip"))
        step = self.config.dt * as_vector(twist, 6, "twist")

        def target(now: pin.SE3) -> tuple[pin.SE3, float]:
            linear, angular = (step[:3], step[3:]) if frame == "world" else (now.rotation @ step[:3], now.rotation @ step[3:])
            return moved(now, linear, angular)

        return self._velocity(q, v, target)

    def _velocity(self, q: FloatArray, v: FloatArray, target: Target) -> FloatArray:
        """Solve for the velocity (n,) that brings the tip to `target(T_world_tip)`."""
        raise NotImplementedError


class DifferentialIK(TipController):
    """Compute joint velocities that move the tip to a pose or with a twist, within the joint limits. Uses PlaCo.

    Call `velocity_to_pose` or `velocity_for_twist` once per control tick. A command depends only on its arguments, not on earlier
    calls. An object must not be used by several threads at once.
    """

    def __init__(
        self,
        model: RobotModel,
        config: DifferentialIKConfig = DifferentialIKConfig(),
        *,
        limits: JointLimits | None = None,
        posture: FloatArray | None = None,
    ) -> None:
        """Prepare a controller.

        Args:
            model: The arm.
            config: Settings.
            limits: Joint limits; None takes those of the arm.
            posture: Configuration (n,) that the null space is moved towards [rad]; None takes the home configuration of the arm.
        """
        super().__init__(model, config, limits=limits, posture=posture)
        self._arm = PlacoArm(model)
        solver = self._arm.solver
        self._tip_task = solver.add_frame_task(model.description.tip_frame, np.eye(4))
        self._tip_task.configure("tip", "soft", config.tip.position_weight, config.tip.rotation_weight)
        self._posture_task = solver.add_joints_task()
        self._posture_task.set_joints(dict(zip(model.description.arm_joints, self.posture.tolist(), strict=True)))
        self._posture_weight = config.posture.weight * min(1.0, config.posture.gain * config.dt)
        self._posture_task.configure("posture", "soft", self._posture_weight)
        solver.enable_joint_limits(True)
        solver.enable_velocity_limits(False)
        self._problem = solver.problem
        self._posture, self._weight, self._singular = config.posture, config.posture.weight, config.posture.singular_below
        self._dt = np.full(model.size, config.dt)
        self._pinocchio, self._data, self._tip_id = model.arm, model.arm.createData(), model.tip_id

    def _velocity(self, q: FloatArray, v: FloatArray, target: Target) -> FloatArray:
        self._arm.set_configuration(q)
        jacobian = pin.computeJointJacobians(self._pinocchio, self._data, q)
        now = pin.updateFramePlacement(self._pinocchio, self._data, self._tip_id)
        goal, step = target(now)
        left = self._manipulability(jacobian)
        damping = self._weight if left >= self._singular else self._posture.damping(left, step)
        self._problem.regularization = damping - self._posture_weight
        self._tip_task.T_world_frame = goal.homogeneous
        try:
            displacement = self._arm.solve(q.tolist(), *self.bounds.displacements(q, v))
        except RuntimeError as error:
            raise InfeasibleControl("DifferentialIK", str(error)) from error
        return displacement / self._dt


class DifferentialIKQP(TipController):
    """Compute the same joint velocities as `DifferentialIK`, with any `QPSolver`."""

    def __init__(
        self,
        model: RobotModel,
        config: DifferentialIKConfig = DifferentialIKConfig(),
        *,
        solver: QPSolver | None = None,
        limits: JointLimits | None = None,
        posture: FloatArray | None = None,
    ) -> None:
        """Prepare a controller; other arguments as in `DifferentialIK`. `solver` solves the QP; None takes OSQP."""
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
