"""Kinematics and dynamics of an arm by Pinocchio: joint limits, forward kinematics, Jacobians and inverse dynamics.

Public joint vectors contain the arm joints, shape (n,), in the order of `RobotDescription.arm_joints`; the fingers are open.
All quantities are in the world frame, in which the base has the `base_pose` of the description.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rlbench_pin.errors import InvalidValue, RobotModelError
from rlbench_pin.robot.description import RobotDescription
from rlbench_pin.robot.fingers import fingers_of
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3, se3_to_pose
from rlbench_pin.urdf import kinematic_urdf
from rlbench_pin.values import as_array, as_choice, as_finite, as_number, as_record, as_vector

TURN = 2.0 * np.pi
"""One revolution of a joint [rad]."""


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of n joints, read-only arrays of shape (n,); velocity, acceleration and effort are symmetric."""

    lower: FloatArray
    """Smallest position [rad] or [m]."""
    upper: FloatArray
    """Largest position [rad] or [m]."""
    velocity: FloatArray
    """Largest speed [rad/s] or [m/s]."""
    acceleration: FloatArray
    """Largest acceleration [rad/s^2] or [m/s^2]."""
    effort: FloatArray
    """Largest torque [N m] or force [N]."""

    def __post_init__(self) -> None:
        """Copy all fields into read-only float arrays of one shape; raise InvalidValue if that is impossible."""
        size = as_array(self.lower, "JointLimits.lower").size
        for name in ("lower", "upper", "velocity", "acceleration", "effort"):
            array = as_array(getattr(self, name), f"JointLimits.{name}").copy()
            if array.shape != (size,) or np.isnan(array).any():
                raise InvalidValue(f"JointLimits.{name}", array, f"has to have shape ({size},), not {array.shape}, without NaN")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if np.any(self.lower > self.upper):
            raise InvalidValue("JointLimits.lower", self.lower, f"has to be below `upper`, which is {self.upper}")
        for name in ("velocity", "acceleration", "effort"):
            if np.any(getattr(self, name) < 0.0):
                raise InvalidValue(f"JointLimits.{name}", getattr(self, name), "has to be >= 0")

    def capped(self, velocity: float, acceleration: float) -> JointLimits:
        """Return these limits, reduced to at most `velocity` [rad/s] and `acceleration` [rad/s^2].

        Raises:
            InvalidValue: One of them is not > 0 (also a ValueError).
        """
        for value, what in ((velocity, "velocity"), (acceleration, "acceleration")):
            as_number(value, what, above=0.0, finite=False)
        return JointLimits(
            self.lower, self.upper, np.minimum(self.velocity, velocity), np.minimum(self.acceleration, acceleration), self.effort
        )

    def contains(self, q: FloatArray, tolerance: float = 0.0) -> bool:
        """Return whether a configuration (n,) is within the position limits."""
        q, tolerance = as_vector(q, len(self.lower), "configuration"), as_number(tolerance, "tolerance", finite=False)
        return bool(np.all(q >= self.lower - tolerance) and np.all(q <= self.upper + tolerance))

    def nearest_turn(self, q: FloatArray, near: FloatArray) -> FloatArray:
        """Return the configuration nearest to `near` that differs from `q` (n,) only by full revolutions of joints.

        Joints whose range is less than one revolution do not change.
        """
        q, near = (as_vector(x, len(self.lower), what) for x, what in ((q, "configuration"), (near, "near")))
        least, most = np.minimum(np.ceil((self.lower - q) / TURN), 0.0), np.maximum(np.floor((self.upper - q) / TURN), 0.0)
        return q + TURN * np.clip(np.round((near - q) / TURN), least, most)

    def margin(self, q: FloatArray) -> float:
        """Return the distance of the joint nearest to one of its position limits."""
        q = as_vector(q, len(self.lower), "configuration")
        return float(min(np.min(q - self.lower), np.min(self.upper - q)))


class ChainReach:
    """Bounds of the distance between points on an arm and the axes of its joints, in all configurations.

    The next joint of the chain has a constant distance from the axis; beyond it the links may be stretched. So
    the part that depends only on the arm, the distance to the last joint of the chain, is computed once.

    Args:
        full: Arm and fingers.
        arm: Names of the arm joints, n of them.
        slide: Range of a finger joint [m].
    """

    def __init__(self, full: pin.Model, arm: tuple[str, ...], slide: float) -> None:
        data = full.createData()
        joints = [full.getJointId(name) for name in arm]
        columns = [full.idx_vs[joint] for joint in joints]
        axes = pin.computeJointJacobians(full, data, pin.neutral(full))[:, columns].T
        self._placements = [data.oMi[i].copy() for i in range(full.njoints)]
        self._axes = axes
        self._links = np.full((full.njoints, len(arm)), -np.inf)
        self._own: dict[int, int] = {}
        for carrier in range(full.njoints):
            chain = list(full.supports[carrier])
            for j in (j for j, joint in enumerate(joints) if joint in chain):
                beyond = chain[chain.index(joints[j]) + 1 :]
                if not beyond:
                    self._own[carrier] = j
                    continue
                near = _distance(axes[j], data.oMi[beyond[0]].translation)
                stretched = sum(float(np.linalg.norm(full.jointPlacements[i].translation)) for i in beyond[1:])
                self._links[carrier, j] = near + stretched + slide * sum(joint not in joints for joint in beyond)

    def of(self, carrier: int, center: FloatArray, radius: float) -> FloatArray:
        """Return the reach of a sphere about the axis of each joint, shape (n,), [m]; 0 for joints that do not carry it.

        Args:
            carrier: Pinocchio joint that carries the sphere.
            center: Centre of the sphere in the frame of that joint (3,), [m].
            radius: Radius of the sphere [m].
        """
        reach = np.maximum(self._links[carrier] + (float(np.linalg.norm(center)) + radius), 0.0)
        own = self._own.get(carrier)
        if own is not None:
            reach[own] = _distance(self._axes[own], self._placements[carrier].act(center)) + radius
        return reach


def _distance(axis: FloatArray, point: FloatArray) -> float:
    """Return the distance [m] of a point (3,) from a joint's axis, a column (6,) of the spatial Jacobian."""
    x, y, z = point.tolist()
    a, b, c = axis[3:].tolist()
    return float(np.linalg.norm(axis[:3] + (b * z - c * y, c * x - a * z, a * y - b * x)))


FrameChoice = Literal["world", "tip"]
_REFERENCE = {"world": pin.LOCAL_WORLD_ALIGNED, "tip": pin.LOCAL}
VELOCITY = "joint velocity"
PANDA_SPEED = 2.175
"""Velocity limit of the slowest joint of the Panda [rad/s]."""
LARGEST = 1e6
"""Upper bound of joint positions, velocities, accelerations and torques, in any unit."""


class RobotModel:
    """Kinematics and dynamics of one arm. Not thread-safe: it reuses its workspace between calls."""

    def __init__(self, description: RobotDescription, base_pose: PoseLike | None = None) -> None:
        """Build the models.

        Args:
            description: The arm.
            base_pose: World pose (7,) of the arm base; None uses the pose in the description.

        Raises:
            RobotModelError: Description and URDF disagree, or the home configuration is outside the joint limits.
        """
        self.description = as_record(description, RobotDescription, "description")
        self.base = pose_to_se3(description.base_pose if base_pose is None else base_pose)
        self.full = _load(description, self.base)
        self.fingers = fingers_of(description)
        self.full_index = _indices(self.full, (*description.arm_joints, *self.fingers.joints))
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
                f"The home configuration of '{description.name}' is outside its joint limits: {description.home}. "
                "Choose another `home`."
            )
        self._bare_inertia = self.arm.inertias[self.size].copy()

    @property
    def slowness(self) -> float:
        """Factor of time limits relative to the Panda: the velocity limit of the slowest joint of the Panda, 2.175 rad/s,
        divided by that of this arm; 1 for the Panda and for faster arms, 3.46 for the Jaco.

        Time limits are chosen for the Panda. This factor multiplies the limits that depend on the speed of the arm: seconds of an
        evaluated episode, steps of a gymnasium episode, ticks of an action by inverse kinematics.
        Limits that do not depend on joint speeds (fingers, settling, planning, demonstrations) are the same for all arms.
        """
        return max(1.0, PANDA_SPEED / float(self.limits.velocity.min()))

    def _lock_fingers(self) -> pin.Model:
        """Return the model of the arm joints alone, fingers fixed open, after checking the order of its joints."""
        description = self.description
        fingers = [self.full.getJointId(name) for name in self.fingers.joints]
        arm = pin.buildReducedModel(self.full, fingers, self.full_configuration(np.zeros(self.size)))
        if tuple(arm.names)[1:] != description.arm_joints:
            raise RobotModelError(
                f"The arm joints of the URDF are {tuple(arm.names)[1:]}, those of the description are {description.arm_joints}. "
                "List `arm_joints` in the order of the URDF."
            )
        return arm

    def full_configuration(self, q: ArrayLike, fingers: ArrayLike | None = None) -> FloatArray:
        """Return the configuration of the full Pinocchio model for an arm (n,) and finger positions (k,) [m]; None is open."""
        arm, count = as_vector(q, self.size, "configuration", most=LARGEST), len(self.fingers.drives)
        open_fingers = np.full(count, self.description.gripper_open)
        positions = open_fingers if fingers is None else as_vector(fingers, count, "finger positions", most=LARGEST)
        result = np.empty(self.full.nq)
        result[self.full_index] = np.concatenate([arm, self.fingers.joint_values(positions)])
        return result

    def _joints(self, vector: ArrayLike, what: str = "configuration") -> FloatArray:
        """Return a vector (n,) of the arm joints, or raise InvalidValue."""
        return as_vector(vector, self.size, what, most=LARGEST)

    @cached_property
    def chain_reach(self) -> ChainReach:
        """Bounds of the distance between points on the arm and the axes of its joints, in all configurations."""
        return ChainReach(self.full, self.description.arm_joints, self.description.gripper_open)

    # Kinematics ---------------------------------------------------------------------------------------------------

    def tip_se3(self, q: ArrayLike) -> pin.SE3:
        """Return T_world_tip."""
        pin.framesForwardKinematics(self.arm, self.data, self._joints(q))
        return self.data.oMf[self.tip_id].copy()

    def tip_pose(self, q: ArrayLike) -> FloatArray:
        """Return the world pose (7,) of the tip."""
        return se3_to_pose(self.tip_se3(q))

    def joint_poses(self, q: ArrayLike) -> list[FloatArray]:
        """Return the world pose (7,) of the frame of each arm joint, base first; joint axes are given in these frames."""
        pin.forwardKinematics(self.arm, self.data, self._joints(q))
        return [se3_to_pose(placement) for placement in self.data.oMi.tolist()[1 : self.size + 1]]

    def jacobian(self, q: ArrayLike, frame: FrameChoice = "world") -> FloatArray:
        """Return J (6, n) with v_tip = J dq, `[linear, angular]`, along world axes or in tip axes."""
        return pin.computeFrameJacobian(self.arm, self.data, self._joints(q), self.tip_id, _reference(frame))

    def jacobian_dot(self, q: ArrayLike, v: ArrayLike, frame: FrameChoice = "world") -> FloatArray:
        """Return dJ/dt (6, n) at joint velocity `v` [rad/s]."""
        pin.computeJointJacobiansTimeVariation(self.arm, self.data, self._joints(q), self._joints(v, VELOCITY))
        pin.updateFramePlacements(self.arm, self.data)
        return np.array(pin.getFrameJacobianTimeVariation(self.arm, self.data, self.tip_id, _reference(frame)))

    def manipulability(self, q: ArrayLike) -> float:
        """Return sqrt(det(J J^T)): 0 in a singular configuration."""
        jacobian = self.jacobian(q)
        return float(np.sqrt(max(0.0, np.linalg.det(jacobian @ jacobian.T))))

    # Dynamics -----------------------------------------------------------------------------------------------------

    def mass_matrix(self, q: ArrayLike) -> FloatArray:
        """Return the joint-space inertia M(q), shape (n, n)."""
        upper = np.triu(pin.crba(self.arm, self.data, self._joints(q)))
        return upper + np.triu(upper, 1).T

    def gravity(self, q: ArrayLike) -> FloatArray:
        """Return the torques that compensate gravity [N m]."""
        return np.array(pin.computeGeneralizedGravity(self.arm, self.data, self._joints(q)))

    def coriolis(self, q: ArrayLike, v: ArrayLike) -> FloatArray:
        """Return C(q, v) v [N m]."""
        q, v = self._joints(q), self._joints(v, VELOCITY)
        return np.array(pin.nonLinearEffects(self.arm, self.data, q, v)) - self.gravity(q)

    def inverse_dynamics(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> FloatArray:
        """Return the torques [N m] that produce acceleration `a` [rad/s^2]."""
        q, v, a = self._joints(q), self._joints(v, VELOCITY), self._joints(a, "joint acceleration")
        return np.array(pin.rnea(self.arm, self.data, q, v, a))

    def forward_dynamics(self, q: ArrayLike, v: ArrayLike, tau: ArrayLike) -> FloatArray:
        """Return the acceleration [rad/s^2] that torques `tau` [N m] produce."""
        q, v, tau = self._joints(q), self._joints(v, VELOCITY), self._joints(tau, "joint torque")
        return np.array(pin.aba(self.arm, self.data, q, v, tau))

    def set_payload(self, mass: float, center: ArrayLike, inertia: ArrayLike | None = None) -> None:
        """Add a payload to the dynamics of the gripper; a mass of 0 removes it.

        Args:
            mass: Mass [kg].
            center: Centre of mass in the tip frame, shape (3,), [m].
            inertia: Rotational inertia about that centre in tip axes, shape (3, 3), [kg m^2]; None is a point mass.

        Raises:
            InvalidValue: A negative mass, NaN, or a wrong shape (also a ValueError).
        """
        mass, center = as_number(mass, "mass [kg]", least=0.0, most=LARGEST), as_vector(center, 3, "center", most=LARGEST)
        load = pin.Inertia(mass, center, np.zeros((3, 3)) if inertia is None else _as_inertia(inertia))
        T_joint_tip = self.arm.frames[self.tip_id].placement
        self.carry(T_joint_tip.act(load) if mass > 0.0 else pin.Inertia.Zero())

    def carry(self, payload: pin.Inertia) -> None:
        """Add an inertia, in the frame of the last joint, to the dynamics of the gripper; it replaces an earlier payload."""
        as_record(payload, pin.Inertia, "payload")
        self.arm.inertias[self.size] = loaded(self._bare_inertia, payload)
        self.data = self.arm.createData()


def loaded(bare: pin.Inertia, payload: pin.Inertia) -> pin.Inertia:
    """Return the inertia of a link with its payload, in one frame; a payload without mass is ignored."""
    return bare + payload if payload.mass > 0.0 else bare.copy()


def _reference(frame: FrameChoice) -> pin.ReferenceFrame:
    """Return the Pinocchio reference of a frame, or raise UnknownName."""
    return _REFERENCE[frame if type(frame) is str and frame in _REFERENCE else as_choice(frame, "frame", ("world", "tip"))]


def _as_inertia(inertia: ArrayLike) -> FloatArray:
    """Return a rotational inertia (3, 3), or raise InvalidValue."""
    matrix = as_finite(as_array(inertia, "inertia"), "inertia")
    if matrix.shape != (3, 3) or np.abs(matrix - matrix.T).max() > 1e-6 or np.linalg.eigvalsh(matrix).min() < -1e-9:
        raise InvalidValue("inertia", inertia, "has to be a symmetric matrix (3, 3) without negative eigenvalues")
    return matrix


def _load(description: RobotDescription, base: pin.SE3) -> pin.Model:
    """Read the URDF and set the world pose of its base."""
    model = pin.buildModelFromXML(kinematic_urdf(description.urdf))
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = base * model.jointPlacements[joint]
    for frame in model.frames:
        if frame.parentJoint == 0 and frame.name != "universe":
            frame.placement = base * frame.placement
    return model


def _indices(model: pin.Model, names: tuple[str, ...]) -> FloatArray:
    """Return the index of each named one-dimensional joint in a Pinocchio configuration."""
    unknown = [name for name in names if not model.existJointName(name)]
    if unknown or model.nq != len(names):
        raise RobotModelError(
            f"The URDF has the joints {tuple(model.names)[1:]}, the description has {names}. "
            "Correct the names in the description."
        )
    return np.array([model.idx_qs[model.getJointId(name)] for name in names])


def _frame_id(model: pin.Model, name: str) -> int:
    if not model.existFrame(name):
        raise RobotModelError(f"The URDF has no frame '{name}'. Use the name of one of its links or joints.")
    return model.getFrameId(name)
