"""Joints: of objects, of the arm, of the gripper."""

from __future__ import annotations

from typing import ClassVar

from pyrep.const import JointMode, JointType
from pyrep.errors import UnsupportedCall
from pyrep.objects.object import Object
from rlbench_pin.compat.joints import JointDrive, drive_of
from rlbench_pin.compat.objects import ObjectType


class Joint(Object):
    """One movable joint, called `<body>/<joint>`, by the joint's name alone where only one body has it, or `Panda_joint1`, ...

    Values are [rad] or [m].
    """

    kinds: ClassVar[tuple[ObjectType, ...]] = ("joint",)

    @property
    def drive(self) -> JointDrive:
        """The object that reads and drives it."""
        return drive_of(self.table, self.element)

    def get_joint_type(self) -> JointType:
        """Return whether it turns or slides."""
        return JointType.PRISMATIC if self.drive.prismatic else JointType.REVOLUTE

    def get_joint_mode(self) -> JointMode:
        """Return FORCE: all joints move by forces."""
        return JointMode.FORCE

    def set_joint_mode(self, value: JointMode) -> None:
        """Accept FORCE, and PASSIVE for joints without a motor of their own.

        Raises:
            UnsupportedCall: Another mode.
        """
        if value not in (JointMode.FORCE, JointMode.PASSIVE):
            raise UnsupportedCall(f"joint mode {value.name}", "joints move by forces.", "Use `set_joint_position`.")
        if value == JointMode.PASSIVE and self.element.kind == "joint":
            self.drive.set_driven(False)

    def get_joint_position(self) -> float:
        """Return its value."""
        return self.drive.position

    def set_joint_position(self, position: float, disable_dynamics: bool = False) -> None:
        """Set its position, at rest; a locked joint is locked there from now on.

        Args:
            position: Where to.
            disable_dynamics: Accepted; it is put there in any case, without physics.
        """
        self.drive.put(float(position))

    def get_joint_target_position(self) -> float:
        """Return the target position of its motor; without a motor its position."""
        return self.drive.target()

    def set_joint_target_position(self, position: float) -> None:
        """Let a motor drive it to a position in the coming steps, and lock it there."""
        self.drive.set_target(float(position))

    def get_joint_target_velocity(self) -> float:
        """Return the target speed of its motor."""
        return self.drive.target_velocity()

    def set_joint_target_velocity(self, velocity: float) -> None:
        """Set the target speed of its motor; joints of objects accept only 0, which locks them."""
        self.drive.set_target_velocity(float(velocity))

    def get_joint_velocity(self) -> float:
        """Return its speed."""
        return self.drive.velocity

    def get_joint_force(self) -> float:
        """Return the force of its motor or spring [N m] or [N]."""
        return self.drive.force

    def set_joint_force(self, force: float) -> None:
        """Cap the force of its motor [N m] or [N]; of the arm or gripper, those of all its motors."""
        self.drive.set_force(float(force))

    def get_joint_interval(self) -> tuple[bool, list[float]]:
        """Return whether it turns without end, and its lowest value and range; [-inf, inf] where it does."""
        low, high = self.drive.limits
        return (True, [low, high]) if high == float("inf") else (False, [low, high - low])

    def set_joint_interval(self, cyclic: bool, interval: list[float]) -> None:
        """Refused: limits are part of the model."""
        raise UnsupportedCall("set_joint_interval", "limits are part of the model file.", "Change them in the URDF.")

    def get_joint_upper_velocity_limit(self) -> float:
        """Return its largest speed; infinite for joints of objects."""
        return self.drive.speed_limit

    def is_control_loop_enabled(self) -> bool:
        """Whether a motor controls its position."""
        return self.drive.is_driven()

    def set_control_loop_enabled(self, value: bool) -> None:
        """Switch position control on or off."""
        self.drive.set_driven(bool(value))

    def is_motor_enabled(self) -> bool:
        """Whether its motor is on; motors of the arm always are."""
        return self.element.kind == "robot_joint" or self.drive.is_driven()

    def set_motor_enabled(self, value: bool) -> None:
        """Lock a joint of an object with a motor, or unlock it; motors of the arm are always on."""
        if self.element.kind == "joint":
            self.drive.set_driven(bool(value))

    def is_motor_locked_at_zero_velocity(self) -> bool:
        """Whether a motor locks it at its position."""
        return self.is_motor_enabled()

    def set_motor_locked_at_zero_velocity(self, value: bool) -> None:
        """Lock a joint of an object at its position, or unlock it; motors of the arm are always on."""
        self.set_motor_enabled(value)
