"""The same inverse kinematics problems by raw PlaCo, Pink and plain Pinocchio, to set beside ours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pink
import pink.exceptions
import pink.limits
import pink.tasks
import pinocchio as pin
import placo

from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray

DT = 0.05
POSTURE_WEIGHT = 1e-5
TOLERANCES = (1e-4, 1e-3)
"""Position [m] and rotation [rad] that count as reached."""


class RawPlaco:
    """PlaCo as its manual has it: tip, posture and regularisation tasks, joint and velocity limits. No acceleration limits."""

    def __init__(self, model: RobotModel) -> None:
        self.robot = placo.RobotWrapper(str(model.description.urdf), int(placo.Flags.ignore_collisions))
        self.robot.set_T_world_fbase(model.base.homogeneous)
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.mask_fbase(True)
        self.solver.dt = DT
        for joint in model.description.gripper_joints:
            self.solver.mask_dof(joint)
        self.solver.enable_joint_limits(True)
        self.solver.enable_velocity_limits(True)
        self.tip = self.solver.add_frame_task(model.description.tip_frame, np.eye(4))
        self.tip.configure("tip", "soft", 1.0, 0.3)
        posture = self.solver.add_joints_task()
        posture.set_joints(dict(zip(model.description.arm_joints, model.home.tolist(), strict=True)))
        posture.configure("posture", "soft", POSTURE_WEIGHT)
        self.solver.add_regularization_task(POSTURE_WEIGHT)
        self.q = np.array(self.robot.state.q)

    def velocity(self, q: FloatArray, v: FloatArray, pose: FloatArray) -> FloatArray:
        """Return joint velocities (7,)."""
        self.q[7:14] = q
        self.robot.state.q = self.q
        self.robot.update_kinematics()
        self.tip.T_world_frame = pin.XYZQUATToSE3(pose).homogeneous
        return self.solver.solve(False)[6:13] / DT


class Pink:
    """Pink with tip and posture tasks, by one of the solvers of qpsolvers.

    With a tick it keeps position, velocity and acceleration limits, braking distance included, as ours does; searching (dt = 1),
    positions only.
    """

    def __init__(self, model: RobotModel, solver: str, dt: float = DT) -> None:
        self.arm, self.solver, self.dt = model.arm, solver, dt
        self.configuration = pink.Configuration(model.arm, model.arm.createData(), model.home)
        self.tip = pink.tasks.FrameTask(
            model.description.tip_frame, position_cost=1.0, orientation_cost=0.55, lm_damping=0.0 if dt < 1.0 else 0.01
        )
        posture = pink.tasks.PostureTask(cost=POSTURE_WEIGHT**0.5)
        posture.set_target(model.home)
        self.tasks = [self.tip, posture] if dt < 1.0 else [self.tip]
        limits = [pink.limits.ConfigurationLimit(model.arm), pink.limits.VelocityLimit(model.arm)]
        self.acceleration = pink.limits.AccelerationLimit(model.arm, np.array(model.limits.acceleration))
        self.limits = [*limits, self.acceleration] if dt < 1.0 else limits[:1]
        self.joint_limits, self.failures = model.limits, 0

    def velocity(self, q: FloatArray, v: FloatArray, pose: FloatArray) -> FloatArray:
        """Return joint velocities (7,), NaN when Pink finds none: its braking distances and limits may contradict."""
        self.configuration.update(q)
        self.acceleration.set_last_integration(v, self.dt)
        self.tip.set_target(pin.XYZQUATToSE3(pose))
        options = {"damping": 1e-9, "limits": self.limits, "safety_break": False}
        try:
            return pink.solve_ik(self.configuration, self.tasks, self.dt, self.solver, **options)
        except pink.exceptions.NoSolutionFound:
            self.failures += 1
            return np.full(len(q), np.nan)

    def reach(self, model: RobotModel, pose: FloatArray, starts: Sequence[FloatArray]) -> bool:
        """Iterate to a pose from each start until one arrives; say whether one did."""
        goal, limits = pin.XYZQUATToSE3(pose), self.joint_limits
        for q in starts:
            for _ in range(60):
                if arrived(model, q, goal):
                    return True
                step = self.dt * self.velocity(q, q, pose)
                if np.isnan(step[0]):
                    break
                q = np.clip(q + step, limits.lower, limits.upper)
        return False


def reach_by_clik(model: RobotModel, pose: FloatArray, starts: Sequence[FloatArray]) -> bool:
    """Plain closed-loop inverse kinematics, as in Pinocchio's examples: damped pseudo-inverse steps, clipped to the limits."""
    goal, limits, data = pin.XYZQUATToSE3(pose), model.limits, model.arm.createData()
    for q in starts:
        for _ in range(200):
            if arrived(model, q, goal):
                return True
            pin.framesForwardKinematics(model.arm, data, q)
            error = pin.log6(data.oMf[model.tip_id].actInv(goal)).vector
            jacobian = pin.computeFrameJacobian(model.arm, data, q, model.tip_id, pin.LOCAL)
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-4 * np.eye(6), error)
            q = np.clip(q + 0.5 * step, limits.lower, limits.upper)
    return False


def arrived(model: RobotModel, q: FloatArray, goal: pin.SE3) -> bool:
    """Say whether the tip is at the goal, within the tolerances."""
    motion = model.tip_se3(q).actInv(goal)
    return bool(
        np.linalg.norm(motion.translation) <= TOLERANCES[0] and np.linalg.norm(pin.log3(motion.rotation)) <= TOLERANCES[1]
    )
