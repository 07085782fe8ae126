"""What an arm can do, analytically: kinematics, Jacobians and dynamics of the arm joints, by Pinocchio.

Public joint vectors are the arm's, shape (n,), in the order of `RobotDescription.arm_joints`; the fingers stand open.
Everything is expressed in the world frame, in which the base has the description's `base_pose`.
"""

from __future__ import annotations

from functools import cached_property
from typing import Literal

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import RobotModelError
from rlbench_pin.robot.chain_reach import ChainReach
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.limits import JointLimits
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3, se3_to_pose

FrameChoice = Literal["world", "tip"]
_REFERENCE = {"world": pin.LOCAL_WORLD_ALIGNED, "tip": pin.LOCAL}


class RobotModel:
    """Kinematics and dynamics of one arm. Not thread-safe: it reuses its work space between calls."""

    def __init__(self, description: RobotDescription, base_pose: PoseLike | None = None) -> None:
        """Build the models.

        Args:
            description: The arm.
            base_pose: Where its base stands in the world (7,); None takes the description's.

        Raises:
            RobotModelError: Description and URDF disagree, or home is outside the joint limits.
        """
        self.description = description
        self.base = pose_to_se3(description.base_pose if base_pose is None else base_pose)
        self.full = _load(description, self.base)
        self.full_index = _indices(self.full, (*description.arm_joints, *description.gripper_joints))
        self.size = len(description.arm_joints)
        self.arm = self._lock_fingers()
        self.data = self.arm.createData()
        self.tip_id = _frame_id(self.arm, description.tip_frame)
        self.home = np.array(description.home)
        self.limits = JointLimits(
            self.arm.lowerPositionLimit,
            self.arm.upperPositionLimit,
            self.arm.velocityLimit,
            np.array(description.acceleration),
            self.arm.effortLimit,
        )
        if not self.limits.contains(self.home):
            raise RobotModelError(
                f"The home configuration of '{description.name}' is outside its joint limits: {description.home}."
            )
        self._bare_inertia = self.arm.inertias[self.size].copy()

    def _lock_fingers(self) -> pin.Model:
        """Return the model of the arm joints alone, fingers fixed open, after checking the order of its joints."""
        description = self.description
        fingers = [self.full.getJointId(name) for name in description.gripper_joints]
        arm = pin.buildReducedModel(self.full, fingers, self.full_configuration(np.zeros(self.size)))
        if tuple(arm.names)[1:] != description.arm_joints:
            raise RobotModelError(
                f"The URDF orders its arm joints {tuple(arm.names)[1:]}, the description {description.arm_joints}."
            )
        return arm

    def full_configuration(self, q: FloatArray, fingers: FloatArray | None = None) -> FloatArray:
        """Return arm and finger positions in the order of the full Pinocchio model; fingers default to open."""
        values = np.full(len(self.full_index), self.description.gripper_open)
        values[: self.size] = q
        if fingers is not None:
            values[self.size :] = fingers
        result = np.empty(self.full.nq)
        result[self.full_index] = values
        return result

    @cached_property
    def chain_reach(self) -> ChainReach:
        """How far what the arm carries can be from the axes of its joints, in any configuration."""
        return ChainReach(self.full, self.description.arm_joints, self.description.gripper_open)

    # Kinematics ---------------------------------------------------------------------------------------------------

    def tip_se3(self, q: FloatArray) -> pin.SE3:
        """Return T_world_tip."""
        pin.framesForwardKinematics(self.arm, self.data, q)
        return self.data.oMf[self.tip_id].copy()

    def tip_pose(self, q: FloatArray) -> FloatArray:
        """Return the tip's pose (7,) in the world."""
        return se3_to_pose(self.tip_se3(q))

    def joint_poses(self, q: FloatArray) -> list[FloatArray]:
        """Return the pose (7,) in the world of every arm joint's frame, base first; the joints turn or slide along its axes."""
        pin.forwardKinematics(self.arm, self.data, q)
        placements = self.data.oMi
        return [se3_to_pose(placements[i]) for i in range(1, self.size + 1)]

    def jacobian(self, q: FloatArray, frame: FrameChoice = "world") -> FloatArray:
        """Return J (6, n) with v_tip = J dq, `[linear, angular]`, along world axes or in tip axes."""
        return pin.computeFrameJacobian(self.arm, self.data, q, self.tip_id, _REFERENCE[frame])

    def jacobian_dot(self, q: FloatArray, v: FloatArray, frame: FrameChoice = "world") -> FloatArray:
        """Return dJ/dt (6, n) at joint velocity `v` [rad/s]."""
        pin.computeJointJacobiansTimeVariation(self.arm, self.data, q, v)
        pin.updateFramePlacements(self.arm, self.data)
        return np.array(pin.getFrameJacobianTimeVariation(self.arm, self.data, self.tip_id, _REFERENCE[frame]))

    def manipulability(self, q: FloatArray) -> float:
        """Return sqrt(det(J J^T)): 0 in a singular configuration."""
        jacobian = self.jacobian(q)
        return float(np.sqrt(max(0.0, np.linalg.det(jacobian @ jacobian.T))))

    # Dynamics -----------------------------------------------------------------------------------------------------

    def mass_matrix(self, q: FloatArray) -> FloatArray:
        """Return the joint-space inertia M(q), shape (n, n)."""
        upper = np.triu(pin.crba(self.arm, self.data, q))
        return upper + np.triu(upper, 1).T

    def gravity(self, q: FloatArray) -> FloatArray:
        """Return the torques that carry the arm's weight [N m]."""
        return np.array(pin.computeGeneralizedGravity(self.arm, self.data, q))

    def coriolis(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return C(q, v) v [N m]."""
        return np.array(pin.nonLinearEffects(self.arm, self.data, q, v)) - self.gravity(q)

    def inverse_dynamics(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return the torques [N m] that produce acceleration `a` [rad/s^2]."""
        return np.array(pin.rnea(self.arm, self.data, q, v, a))

    def forward_dynamics(self, q: FloatArray, v: FloatArray, tau: FloatArray) -> FloatArray:
        """Return the acceleration [rad/s^2] that torques `tau` [N m] produce."""
        return np.array(pin.aba(self.arm, self.data, q, v, tau))

    def set_payload(self, mass: float, center: FloatArray, inertia: FloatArray | None = None) -> None:
        """Add a body to the dynamics of the hand; a mass of 0 takes it away.

        Args:
            mass: [kg].
            center: Centre of mass in the tip frame, shape (3,), [m].
            inertia: Rotational inertia about that centre in tip axes, shape (3, 3), [kg m^2]; None is a point.
        """
        load = pin.Inertia(mass, np.asarray(center, dtype=float), np.zeros((3, 3)) if inertia is None else np.asarray(inertia))
        T_joint_tip = self.arm.frames[self.tip_id].placement
        self.carry(T_joint_tip.act(load) if mass > 0.0 else pin.Inertia.Zero())

    def carry(self, payload: pin.Inertia) -> None:
        """Add an inertia, in the frame of the last joint, to the dynamics of the hand; it replaces what was added before."""
        self.arm.inertias[self.size] = self._bare_inertia + payload if payload.mass > 0.0 else self._bare_inertia.copy()
        self.data = self.arm.createData()


def _load(description: RobotDescription, base: pin.SE3) -> pin.Model:
    """Read the URDF and put its base where it stands in the world."""
    model = pin.buildModelFromUrdf(str(description.urdf))
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = base * model.jointPlacements[joint]
    for frame in model.frames:
        if frame.parentJoint == 0 and frame.name != "universe":
            frame.placement = base * frame.placement
    return model


def _indices(model: pin.Model, names: tuple[str, ...]) -> FloatArray:
    """Return where each named one-dimensional joint sits in a Pinocchio configuration."""
    unknown = [name for name in names if not model.existJointName(name)]
    if unknown or model.nq != len(names):
        raise RobotModelError(f"The URDF has joints {tuple(model.names)[1:]}, the description {names}.")
    return np.array([model.idx_qs[model.getJointId(name)] for name in names])


def _frame_id(model: pin.Model, name: str) -> int:
    if not model.existFrame(name):
        raise RobotModelError(f"The URDF has no frame '{name}'.")
    return model.getFrameId(name)
