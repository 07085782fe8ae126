"""Joints of objects, of the arm and of the gripper."""

from __future__ import annotations

from typing import ClassVar

from pyrep.const import JointMode, JointType
from pyrep.errors import UnsupportedCall
from pyrep.objects.object import Object
from rlbench_pin.compat.joints import JointDrive, drive_of
from rlbench_pin.compat.objects import ObjectType


class Joint(Object):
    """A movable joint. Positions are [rad] or [m].

    Its name is `<body>/<joint>`, or the name of the joint if it is unique. Joints of the arm are `Panda_joint1`, ...
    """

    kinds: ClassVar[tuple[ObjectType, ...]] = ("joint",)

    @property
    def drive(self) -> JointDrive:
        """Access to the joint in the simulation."""
        return drive_of(self.table, self.element)

    def get_joint_type(self) -> JointType:
        """Return the type of the joint, REVOLUTE or PRISMATIC."""
        return JointType.PRISMATIC if self.drive.prismatic else JointType.REVOLUTE

    def get_joint_mode(self) -> JointMode:
        """Return FORCE, the mode of all joints."""
        return JointMode.FORCE

    def set_joint_mode(self, value: JointMode) -> None:
        """Set the mode: FORCE has no effect, PASSIVE unlocks a joint of an object.

        Raises:
            UnsupportedCall: `value` is another mode.
        """
        if value not in (JointMode.FORCE, JointMode.PASSIVE):
            raise UnsupportedCall(f"joint mode {value.name}", "joints move by forces.", "Use `set_joint_position`.")
        if value == JointMode.PASSIVE and self.element.kind == "joint":
            self.drive.set_driven(False)

    def get_joint_position(self) -> float:
        """Return the position [rad] or [m]."""
        return self.drive.position

    def set_joint_position(self, position: float, disable_dynamics: bool = False) -> None:
        """Set the position, with velocity 0; a locked joint is then locked at the new position.

        Args:
            position: New position [rad] or [m].
            disable_dynamics: No effect: the position is always set without physics.
        """
        self.drive.put(float(position))

    def get_joint_target_position(self) -> float:
        """Return the target position of the motor; without a motor the position."""
        return self.drive.target()

    def set_joint_target_position(self, position: float) -> None:
        """Move the joint to a position by its motor in the next steps, and lock it there."""
        self.drive.set_target(float(position))

    def get_joint_target_velocity(self) -> float:
        """Return the target velocity of the motor."""
        return self.drive.target_velocity()

    def set_joint_target_velocity(self, velocity: float) -> None:
        """Set the target velocity of the motor; joints of objects accept only 0, which locks them."""
        self.drive.set_target_velocity(float(velocity))

    def get_joint_velocity(self) -> float:
        """Return the velocity [rad/s] or [m/s]."""
        return self.drive.velocity

    def get_joint_force(self) -> float:
        """Return the force of the motor or spring [N m] or [N]."""
        return self.drive.force

    def set_joint_force(self, force: float) -> None:
        """Set the maximum force of the motor [N m] or [N]; for the arm or gripper it applies to all its motors."""
        self.drive.set_force(float(force))

    def get_joint_interval(self) -> tuple[bool, list[float]]:
        """Return whether the joint has no limits, and its lower limit and range; without limits [-inf, inf]."""
        low, high = self.drive.limits
        return (True, [low, high]) if high == float("inf") else (False, [low, high - low])

    def set_joint_interval(self, cyclic: bool, interval: list[float]) -> None:
        """Raise UnsupportedCall: limits are part of the model."""
        raise UnsupportedCall("set_joint_interval", "limits are part of the model file.", "Change them in the URDF.")

    def get_joint_upper_velocity_limit(self) -> float:
        """Return the velocity limit; infinite for joints of objects."""
        return self.drive.speed_limit

    def is_control_loop_enabled(self) -> bool:
        """Return whether a motor controls the position."""
        return self.drive.is_driven()

    def set_control_loop_enabled(self, value: bool) -> None:
        """Switch position control on or off."""
        self.drive.set_driven(bool(value))

    def is_motor_enabled(self) -> bool:
        """Return whether the motor is on; motors of the robot are always on."""
        return self.element.kind == "robot_joint" or self.drive.is_driven()

    def set_motor_enabled(self, value: bool) -> None:
        """Lock a joint of an object by a motor, or unlock it; motors of the robot are always on."""
        if self.element.kind == "joint":
            self.drive.set_driven(bool(value))

    def is_motor_locked_at_zero_velocity(self) -> bool:
        """Return whether a motor locks the joint at its position."""
        return self.is_motor_enabled()

    def set_motor_locked_at_zero_velocity(self, value: bool) -> None:
        """Lock a joint of an object at its position, or unlock it; motors of the robot are always on."""
        self.set_motor_enabled(value)
