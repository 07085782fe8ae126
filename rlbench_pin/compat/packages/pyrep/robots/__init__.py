"""Base class of arms and grippers, which are views on the robot of the current world.

Programs import `RobotComponent` from `pyrep.robots.robot_component`; that name is an alias of this module.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pyrep.const import JointMode, JointType, ObjectType
from pyrep.errors import UnsupportedCall
from pyrep.objects.joint import Joint
from pyrep.objects.object import Numbers, Object
from pyrep.objects.shape import Shape
from rlbench_pin.compat import add_aliases
from rlbench_pin.compat.joints import Motors
from rlbench_pin.compat.objects.elements import robot_names
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.spatial import FloatArray


class RobotComponent(Object):
    """An arm or a gripper of the current world; each list of numbers has one value per joint, in the order of `joints`.

    Args:
        count: Index of the robot; only 0 is possible, since a world has one robot.
        name: Name of the component.
        joint_names: Names of the joints.
        base_name: Name of the base object; None is `name`.

    Attributes:
        joints: The joints.
    """

    def __init__(self, count: int, name: str, joint_names: Sequence[str], base_name: str | None = None) -> None:
        require_only_one(count, name)
        super().__init__(name if base_name is None else base_name)
        self.joints: list[Joint] = [Joint(joint) for joint in joint_names]
        self._num_joints = len(self.joints)

    @property
    def motors(self) -> Motors:
        """The motors of the joints."""
        raise NotImplementedError(f"{type(self).__name__} has no motors of its own. Derive from `Arm` or `Gripper`.")

    def copy(self) -> RobotComponent:
        """Raise UnsupportedCall: a world has one robot."""
        raise UnsupportedCall(f"copy of '{self.get_name()}'", "a world has one robot.", "Use one process per robot.")

    def get_joint_count(self) -> int:
        """Return the number of joints."""
        return self._num_joints

    def get_joint_types(self) -> list[JointType]:
        """Return the types of the joints."""
        return [joint.get_joint_type() for joint in self.joints]

    # Positions -------------------------------------------------------------------------------------------------------

    def get_joint_positions(self) -> list[float]:
        """Return measured joint positions [rad] or [m]."""
        return self.motors.positions().tolist()

    def set_joint_positions(self, positions: Numbers, disable_dynamics: bool = False) -> None:
        """Set the joint positions with velocity 0, and hold them.

        Args:
            positions: One position per joint [rad] or [m].
            disable_dynamics: No effect: positions are always set without physics.
        """
        self.motors.teleport(self._numbers(positions))

    def get_joint_target_positions(self) -> list[float]:
        """Return the target positions of the motors [rad] or [m]."""
        return self.motors.target_positions().tolist()

    def set_joint_target_positions(self, positions: Numbers) -> None:
        """Set the target joint positions [rad] or [m] of the next steps; an arm switches to position control."""
        self.motors.set_target_positions(self._numbers(positions))

    # Velocities and forces -------------------------------------------------------------------------------------------

    def get_joint_velocities(self) -> list[float]:
        """Return measured joint velocities [rad/s] or [m/s]."""
        return self.motors.velocities().tolist()

    def get_joint_target_velocities(self) -> list[float]:
        """Return the target velocities [rad/s] or [m/s]."""
        return self.motors.target_velocities().tolist()

    def set_joint_target_velocities(self, velocities: Numbers) -> None:
        """Set the target joint velocities [rad/s] or [m/s] until the next command; an arm switches to velocity control."""
        self.motors.set_target_velocities(self._numbers(velocities))

    def get_joint_forces(self) -> list[float]:
        """Return the forces of the motors in the last physics step [N m] or [N]."""
        return self.motors.forces().tolist()

    def set_joint_forces(self, forces: Numbers) -> None:
        """Set the maximum forces of the motors [N m] or [N]; `ArmMotors.set_forces` states when they apply for an arm."""
        self.motors.set_forces(self._numbers(forces))

    # Limits ----------------------------------------------------------------------------------------------------------

    def get_joint_intervals(self) -> tuple[list[bool], list[list[float]]]:
        """Return which joints have no limits (none), and the lower limit and range of each joint [rad] or [m]."""
        low, high = self.motors.limits()
        return [False] * self._num_joints, np.array([low, high - low]).T.tolist()

    def set_joint_intervals(self, cyclic: Sequence[bool], intervals: Sequence[Sequence[float]]) -> None:
        """Raise UnsupportedCall: the limits are part of the model."""
        raise UnsupportedCall(
            "set_joint_intervals", "joint limits are part of the URDF of the robot.", "Clip your targets instead."
        )

    def get_joint_upper_velocity_limits(self) -> list[float]:
        """Return the velocity limits [rad/s] or [m/s]."""
        return self.motors.velocity_limits().tolist()

    # Modes -----------------------------------------------------------------------------------------------------------

    def set_control_loop_enabled(self, value: bool) -> None:
        """Switch to position control (True), or to velocity control with velocity 0 (False)."""
        self.motors.set_control_loop(bool(value))

    def set_motor_locked_at_zero_velocity(self, value: bool) -> None:
        """No effect: motors with a target velocity of 0 always hold the joints."""

    def get_joint_modes(self) -> list[JointMode]:
        """Return FORCE for each joint."""
        return [JointMode.FORCE] * self._num_joints

    def set_joint_mode(self, value: JointMode) -> None:
        """No effect for `JointMode.FORCE`, the mode of all joints.

        Raises:
            UnsupportedCall: `value` is another mode.
        """
        if value != JointMode.FORCE:
            raise UnsupportedCall(
                f"joint mode {value.name}", "a robot's joints are driven by forces.", "Use `set_joint_positions`."
            )

    # Appearance ------------------------------------------------------------------------------------------------------

    def get_visuals(self) -> list[Shape]:
        """Return the shapes of the component."""
        return [Shape(item.get_name()) for item in self.get_objects_in_tree(object_type=ObjectType.SHAPE)]

    def _numbers(self, values: Numbers) -> FloatArray:
        """Return values as an array (n,), or raise ValueError if there is not one value per joint."""
        numbers = np.array(values, dtype=float).reshape(-1)
        if len(numbers) != self._num_joints:
            raise ValueError(
                f"'{self.get_name()}' has {self._num_joints} joints, but {len(numbers)} values were given. Pass one per joint."
            )
        return numbers


def require_only_one(count: int, name: str) -> None:
    """Raise UnsupportedCall if `count` is not 0, or if the current world has another robot."""
    running = Simulator.current().model.description
    names = robot_names(running)
    if name not in (names.arm, names.gripper):
        raise UnsupportedCall(
            f"robot '{name}'",
            f"the robot of this world is the {running.name}, called '{names.arm}' and '{names.gripper}'.",
            "Pass the `robot_setup` of another one to `Environment`, or use the names of this one.",
        )
    if count:
        raise UnsupportedCall(f"robot '{name}' with count={count}", "a world has one robot.", "Use count=0.")


add_aliases(__name__, ["robot_component"])
