"""Joints of objects and of the robot: read, drive and restore them.

`ArmMotors` and `FingerMotors` have the same methods. Each vector (n,) has one value per joint: [rad], [rad/s] and [N m] for the
arm, [m], [m/s] and [N] for the fingers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.compat.objects import Element, ObjectTable, UnsupportedCall
from rlbench_pin.compat.objects.elements import robot_names
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.sim import ObjectJoint
from rlbench_pin.spatial import FloatArray, compose

Numbers = Sequence[float] | FloatArray


@dataclass
class Requested:
    """Motor commands of a program that have no equivalent in this simulator."""

    velocities: FloatArray
    """Target velocities (n,)."""
    forces: FloatArray
    """Maximum forces (n,)."""


def _vector(numbers: Numbers, size: int, what: str) -> FloatArray:
    """Return the numbers as an array (size,), or raise ValueError with `what` if they are not finite or too few or many."""
    values = np.array(numbers, dtype=float)
    if values.shape != (size,) or not np.isfinite(values).all():
        raise ValueError(f"{what} have to be {size} finite numbers, not {numbers!r}.")
    return values


class ArmMotors:
    """Motors of the arm of the current simulator."""

    @property
    def _runtime(self) -> Runtime:
        return Simulator.current().runtime

    @property
    def _requested(self) -> Requested:
        """Commands of the program; initially velocity 0 and the full force of the motors."""
        runtime = self._runtime
        return runtime.kept(ArmMotors, lambda: Requested(np.zeros(runtime.model.size), runtime.robot.effort_limits.copy()))

    def positions(self) -> FloatArray:
        """Measured positions."""
        return self._runtime.robot.joint_positions

    def velocities(self) -> FloatArray:
        """Measured velocities."""
        return self._runtime.robot.joint_velocities

    def forces(self) -> FloatArray:
        """Forces of the motors in the last physics step."""
        return self._runtime.robot.joint_torques

    def limits(self) -> FloatArray:
        """Lower and upper position limits, shape (2, n)."""
        return np.array([self._runtime.robot.lower, self._runtime.robot.upper])

    def velocity_limits(self) -> FloatArray:
        """Velocity limits."""
        return self._runtime.robot.velocity_limits.copy()

    def teleport(self, positions: Numbers) -> None:
        """Set the joint positions with velocity 0; grasped bodies move with the gripper."""
        runtime = self._runtime
        runtime.robot.reset_configuration(np.asarray(positions, dtype=float))
        hand = runtime.robot.link_pose(runtime.description.hand_link)
        for held in runtime.gripper.attachments():
            runtime.world.body(held.body).set_pose(compose(hand, held.T_hand_body))

    def target_positions(self) -> FloatArray:
        """Target positions; without position control the measured positions."""
        control = self._runtime.robot.control
        return control.target.copy() if control.mode == "position" else self.positions()

    def set_target_positions(self, positions: Numbers) -> None:
        """Set target positions, and switch to position control."""
        self._runtime.robot.set_position_targets(np.asarray(positions, dtype=float))

    def target_velocities(self) -> FloatArray:
        """Target velocities; 0 with position control."""
        return self._requested.velocities.copy() if not self.control_loop() else np.zeros(self._runtime.model.size)

    def set_target_velocities(self, velocities: Numbers) -> None:
        """Set target velocities, and switch to velocity control.

        Velocities beyond the limit of a joint with force limits select torque control; see `set_forces`.
        """
        self._requested.velocities = _vector(velocities, self._runtime.model.size, "joint velocities")
        self._drive()

    def set_forces(self, forces: Numbers) -> None:
        """Limit the motor torques.

        A limit applies only if the requested velocity is beyond the limit of the joint: then it is the applied torque, in the
        direction of that velocity. Motors that follow positions or reachable velocities use the force that they need.
        """
        self._requested.forces = np.abs(_vector(forces, self._runtime.model.size, "joint forces"))
        if not self.control_loop():
            self._drive()

    def control_loop(self) -> bool:
        """Whether position control is on."""
        return self._runtime.robot.mode == "position"

    def set_control_loop(self, enabled: bool) -> None:
        """Switch to position control at the measured positions, or to velocity control with velocity 0."""
        if enabled and not self.control_loop():
            self._runtime.hold()
        elif not enabled and self.control_loop():
            self.set_target_velocities(np.zeros(self._runtime.model.size))

    def _drive(self) -> None:
        """Apply the requested commands: torques for velocities beyond the limits with limited forces, otherwise velocities."""
        robot, requested = self._runtime.robot, self._requested
        out_of_reach = bool((np.abs(requested.velocities) > robot.velocity_limits).any())
        if out_of_reach and bool((requested.forces < robot.effort_limits).any()):
            robot.set_torques(np.sign(requested.velocities) * requested.forces)
        else:
            robot.set_velocity_targets(requested.velocities)


class FingerMotors:
    """Motors of the gripper of the current simulator; the fingers are coupled, so the mean of the requested values applies."""

    @property
    def _runtime(self) -> Runtime:
        return Simulator.current().runtime

    @property
    def _requested(self) -> Requested:
        """Commands of the program; initially velocity 0 and the full force of the motors."""
        force = self._runtime.description.gripper_force
        return self._runtime.kept(FingerMotors, lambda: Requested(np.zeros(self._count), np.full(self._count, force)))

    @property
    def _count(self) -> int:
        return len(self._runtime.description.gripper_joints)

    def positions(self) -> FloatArray:
        return self._runtime.robot.fingers

    def velocities(self) -> FloatArray:
        robot = self._runtime.robot
        return robot.joint_states()[1, self._runtime.model.size :] / robot.grip.lever(robot.fingers)

    def forces(self) -> FloatArray:
        robot = self._runtime.robot
        return robot.joint_states()[2, self._runtime.model.size :] * robot.grip.lever(robot.fingers)

    def limits(self) -> FloatArray:
        return np.array([np.zeros(self._count), np.full(self._count, self._runtime.description.gripper_open)])

    def velocity_limits(self) -> FloatArray:
        """Finger speeds of gripper actions; a program can request higher ones."""
        return np.full(self._count, self._runtime.description.finger_speed)

    def teleport(self, positions: Numbers) -> None:
        """Set the finger positions with velocity 0; the arm does not change."""
        runtime = self._runtime
        states, fingers = runtime.robot.joint_states(), slice(runtime.model.size, None)
        opening = np.clip(_vector(positions, self._count, "finger positions"), *self.limits())
        states[0, fingers] = runtime.robot.grip.drive_values(opening)
        states[1, fingers] = 0.0
        runtime.robot.set_joint_states(states[0], states[1])
        runtime.gripper.hold()

    def target_positions(self) -> FloatArray:
        return self._runtime.gripper.control.target.copy()

    def set_target_positions(self, positions: Numbers) -> None:
        self._go(float(_vector(positions, self._count, "finger positions").mean()), self._runtime.description.finger_speed)

    def target_velocities(self) -> FloatArray:
        return self._requested.velocities.copy()

    def set_target_velocities(self, velocities: Numbers) -> None:
        """Open if the mean velocity is positive, close if it is negative, hold the position if it is 0."""
        requested = self._requested
        requested.velocities = _vector(velocities, self._count, "finger velocities")
        speed = float(requested.velocities.mean())
        if speed == 0.0:
            self._runtime.gripper.hold()
        else:
            self._go(self._runtime.description.gripper_open if speed > 0.0 else 0.0, abs(speed))

    def set_forces(self, forces: Numbers) -> None:
        """Set the maximum forces of the fingers for the next motions."""
        self._requested.forces = np.abs(_vector(forces, self._count, "finger forces"))

    def control_loop(self) -> bool:
        """Always True: finger motors follow positions at a given speed."""
        return True

    def set_control_loop(self, enabled: bool) -> None:
        """No effect: target velocities move the fingers in both modes."""

    def open_to(self, amount: float, speed: float) -> None:
        """Move to an opening (0 closed to 1 open) at a finger speed [m/s] with the maximum force of `set_forces`."""
        self._runtime.gripper.set_target(amount, speed, float(self._requested.forces.mean()) or None)

    def _go(self, position: float, speed: float) -> None:
        """Move to a finger position [m] at a speed [m/s]."""
        self.open_to(float(np.clip(position / self._runtime.description.gripper_open, 0.0, 1.0)), speed)


Motors = ArmMotors | FingerMotors


class BodyJointDrive:
    """Access to a joint of an object; its only motor is the stiff lock."""

    speed_limit = float("inf")

    def __init__(self, joint: ObjectJoint, prismatic: bool) -> None:
        self._joint, self.prismatic = joint, prismatic

    @property
    def position(self) -> float:
        return float(self._joint.position)

    @property
    def velocity(self) -> float:
        return float(self._joint.velocity)

    @property
    def force(self) -> float:
        """Current force of the spring; 0 without a spring or when locked, since forces of locks are not measured."""
        spring = self._joint.spec.spring
        if spring is None or self._joint.locked:
            return 0.0
        return float(spring.stiffness * (spring.rest - self.position) - spring.damping * self.velocity)

    @property
    def limits(self) -> tuple[float, float]:
        return float(self._joint.lower), float(self._joint.upper)

    def put(self, position: float) -> None:
        """Set the joint position, with velocity 0."""
        self._joint.set_position(float(position))

    def target(self) -> float:
        """Position of the lock; the measured position if the joint is not locked."""
        locked = self._joint.lock_position
        return self.position if locked is None else float(locked)

    def set_target(self, position: float) -> None:
        """Lock the joint at a position; the motor moves it there as fast as its force allows."""
        self._joint.set_lock(float(np.clip(position, *self.limits)))

    def target_velocity(self) -> float:
        """0: joints of objects have no velocity motors."""
        return 0.0

    def set_target_velocity(self, velocity: float) -> None:
        """Lock the joint at its current position if `velocity` is 0; raise UnsupportedCall otherwise."""
        if velocity != 0.0:
            raise UnsupportedCall(
                f"set_joint_target_velocity({velocity}) of '{self._joint.name}'",
                "joints of objects have no velocity motors.",
                "Call `set_joint_position` or `set_joint_target_position` in `step()`, or give the joint a spring.",
            )
        self._joint.lock()

    def set_force(self, force: float) -> None:
        raise UnsupportedCall(
            f"set_joint_force of '{self._joint.name}'",
            "joints of objects have friction and springs, not motors.",
            "Set `friction` or `spring` of the joint in the scene file.",
        )

    def is_driven(self) -> bool:
        """Whether the joint is locked."""
        return bool(self._joint.locked)

    def set_driven(self, driven: bool) -> None:
        """Lock the joint at its current position, or unlock it."""
        if driven != self._joint.locked:
            self._joint.set_lock(self.position if driven else None)


class RobotJointDrive:
    """Access to one joint of the arm or gripper; the other joints keep their commands."""

    def __init__(self, motors: Motors, index: int, prismatic: bool) -> None:
        self._motors, self._index, self.prismatic = motors, index, prismatic

    @property
    def position(self) -> float:
        return float(self._motors.positions()[self._index])

    @property
    def velocity(self) -> float:
        return float(self._motors.velocities()[self._index])

    @property
    def force(self) -> float:
        """Force of the motor in the last physics step."""
        return float(self._motors.forces()[self._index])

    @property
    def limits(self) -> tuple[float, float]:
        low, high = self._motors.limits()[:, self._index]
        return float(low), float(high)

    @property
    def speed_limit(self) -> float:
        return float(self._motors.velocity_limits()[self._index])

    def put(self, position: float) -> None:
        """Set the joint position, with velocity 0 for all joints; the others keep their positions."""
        self._motors.teleport(self._with(self._motors.positions(), position))

    def target(self) -> float:
        return float(self._motors.target_positions()[self._index])

    def set_target(self, position: float) -> None:
        self._motors.set_target_positions(self._with(self._motors.target_positions(), position))

    def target_velocity(self) -> float:
        return float(self._motors.target_velocities()[self._index])

    def set_target_velocity(self, velocity: float) -> None:
        self._motors.set_target_velocities(self._with(self._motors.target_velocities(), velocity))

    def set_force(self, force: float) -> None:
        """Set the maximum force of all joints of the arm or gripper; single joints have no own limit."""
        self._motors.set_forces(np.full(len(self._motors.positions()), force))

    def is_driven(self) -> bool:
        """Whether position control is on."""
        return self._motors.control_loop()

    def set_driven(self, driven: bool) -> None:
        """Switch all joints of the arm or gripper to position control or velocity control."""
        self._motors.set_control_loop(driven)

    def _with(self, values: np.ndarray, value: float) -> np.ndarray:
        """Return a copy of values (n,) with the value of this joint replaced."""
        changed = np.array(values, dtype=float)
        changed[self._index] = value
        return changed


JointDrive = BodyJointDrive | RobotJointDrive


def drive_of(table: ObjectTable, element: Element) -> JointDrive:
    """Return the access to a joint of an object or of the robot."""
    if element.kind == "joint":
        joint = table.world.joint(element.name)
        owner, _, name = element.name.partition("/")
        return BodyJointDrive(joint, table.world.body(owner).model.joints[name].prismatic)
    is_finger, index = robot_names(table.runtime.description).place(element.name)
    return RobotJointDrive(FingerMotors() if is_finger else ArmMotors(), index, prismatic=is_finger)


@dataclass(frozen=True, eq=False)
class ConfigurationTree:
    """Poses and joint values of an object and its descendants, at one instant."""

    poses: dict[Element, FloatArray]
    """Poses (7,) in the world, parents first."""
    joints: dict[Element, float]
    """Joint values [rad] or [m]."""

    @classmethod
    def read(cls, table: ObjectTable, root: Element) -> ConfigurationTree:
        """Return the configuration of an object and its descendants."""
        tree = table.tree(root)
        members = [root, *sorted(tree, key=lambda element: len(table.ancestors(element)))]
        poses = {e: table.scene_object(e).pose for e in members if e.kind in ("root", "body", "frame", "placed")}
        return cls(poses, {e: drive_of(table, e).position for e in members if e.kind in ("joint", "robot_joint")})

    def write(self, table: ObjectTable) -> None:
        """Restore all poses and joint positions, with velocity 0; objects that no longer exist are skipped."""
        for element, pose in self.poses.items():
            if table.exists(element):
                table.scene_object(element).set_pose(pose, True)
        for element, position in self.joints.items():
            if table.exists(element):
                drive_of(table, element).put(position)
