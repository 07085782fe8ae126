"""Joints of bodies and of the robot behind one small interface."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from rlbench_pin.compat.motors import ArmMotors, FingerMotors, Motors
from rlbench_pin.compat.things.element import Element, UnsupportedCall
from rlbench_pin.compat.things.table import ObjectTable
from rlbench_pin.sim import ObjectJoint


class JointDrive(Protocol):
    """One joint: reading, placing, driving; [rad] or [m]."""

    position: float
    velocity: float
    force: float
    limits: tuple[float, float]
    speed_limit: float

    def put(self, position: float) -> None:
        """Put the joint at a value, at rest."""
        ...

    def target(self) -> float:
        """Return where its motor goes; where it is without one."""
        ...

    def set_target(self, position: float) -> None:
        """Let a motor drive it to a value."""
        ...

    def target_velocity(self) -> float:
        """Return the speed that its motor was asked for."""
        ...

    def set_target_velocity(self, velocity: float) -> None:
        """Let a motor turn it at a speed."""
        ...

    def set_force(self, force: float) -> None:
        """Cap the force of its motor."""
        ...

    def is_driven(self) -> bool:
        """Whether a motor controls its position."""
        ...

    def set_driven(self, driven: bool) -> None:
        """Let a motor hold its position, or let go."""
        ...


class BodyJointDrive:
    """A joint of an object; its motor is the stiff one that locks it."""

    def __init__(self, joint: ObjectJoint, prismatic: bool) -> None:
        self._joint, self.prismatic = joint, prismatic

    @property
    def position(self) -> float:
        """Value now."""
        return float(self._joint.position)

    @property
    def velocity(self) -> float:
        """Speed now."""
        return float(self._joint.velocity)

    @property
    def force(self) -> float:
        """Force of the spring now; motors that lock are not measured."""
        spring = self._joint.spec.spring
        if spring is None or self._joint.locked:
            return 0.0
        return float(spring.stiffness * (spring.rest - self.position) - spring.damping * self.velocity)

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest value."""
        return float(self._joint.lower), float(self._joint.upper)

    @property
    def speed_limit(self) -> float:
        """None: infinite."""
        return float("inf")

    def put(self, position: float) -> None:
        """Put the joint there, at rest."""
        self._joint.set_position(float(position))

    def target(self) -> float:
        """Where it is locked, or is."""
        locked = self._joint.lock_position
        return self.position if locked is None else float(locked)

    def set_target(self, position: float) -> None:
        """Lock the joint at a value: the motor drives it there, as fast as its force allows."""
        self._joint.set_lock(float(np.clip(position, *self.limits)))

    def target_velocity(self) -> float:
        """0: joints of objects have no motors that turn."""
        return 0.0

    def set_target_velocity(self, velocity: float) -> None:
        """Zero locks the joint where it is.

        Raises:
            UnsupportedCall: Another speed.
        """
        if velocity != 0.0:
            raise UnsupportedCall(
                f"set_joint_target_velocity({velocity}) of '{self._joint.name}'",
                "joints of objects have no motors that turn.",
                "Call `set_joint_position` or `set_joint_target_position` in `step()`, or give the joint a spring.",
            )
        self._joint.lock()

    def set_force(self, force: float) -> None:
        """Refused."""
        raise UnsupportedCall(
            f"set_joint_force of '{self._joint.name}'",
            "joints of objects are held by friction and springs.",
            "Set `friction` or `spring` of the joint in the scene file.",
        )

    def is_driven(self) -> bool:
        """Whether it is locked."""
        return bool(self._joint.locked)

    def set_driven(self, driven: bool) -> None:
        """Lock the joint where it is, or unlock it."""
        if driven != self._joint.locked:
            self._joint.set_lock(self.position if driven else None)


class RobotJointDrive:
    """A joint of the arm or hand; the others keep their commands."""

    def __init__(self, motors: Motors, index: int, prismatic: bool) -> None:
        self._motors, self._index, self.prismatic = motors, index, prismatic

    @property
    def position(self) -> float:
        """Value now."""
        return float(self._motors.positions()[self._index])

    @property
    def velocity(self) -> float:
        """Speed now."""
        return float(self._motors.velocities()[self._index])

    @property
    def force(self) -> float:
        """Force of the motor in the last physics step."""
        return float(self._motors.forces()[self._index])

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest value."""
        low, high = self._motors.limits()[:, self._index]
        return float(low), float(high)

    @property
    def speed_limit(self) -> float:
        """Largest speed."""
        return float(self._motors.velocity_limits()[self._index])

    def put(self, position: float) -> None:
        """Put the joint there, at rest; the others stay."""
        self._motors.teleport(self._with(self._motors.positions(), position))

    def target(self) -> float:
        """Where its motor goes."""
        return float(self._motors.target_positions()[self._index])

    def set_target(self, position: float) -> None:
        """Drive the joint to a value."""
        self._motors.set_target_positions(self._with(self._motors.target_positions(), position))

    def target_velocity(self) -> float:
        """The speed that was asked for."""
        return float(self._motors.target_velocities()[self._index])

    def set_target_velocity(self, velocity: float) -> None:
        """Turn the joint at a speed."""
        self._motors.set_target_velocities(self._with(self._motors.target_velocities(), velocity))

    def set_force(self, force: float) -> None:
        """Cap the forces of all joints of the component alike: single caps are not kept apart."""
        self._motors.set_forces(np.full(len(self._motors.positions()), force))

    def is_driven(self) -> bool:
        """Whether positions are controlled."""
        return self._motors.control_loop()

    def set_driven(self, driven: bool) -> None:
        """Control positions or velocities, of all joints of the component."""
        self._motors.set_control_loop(driven)

    def _with(self, values: np.ndarray, value: float) -> np.ndarray:
        changed = np.array(values, dtype=float)
        changed[self._index] = value
        return changed


def drive_of(table: ObjectTable, element: Element) -> BodyJointDrive | RobotJointDrive:
    """Return what reads and drives a joint."""
    if element.kind == "joint":
        joint = table.world.joint(element.name)
        owner, _, name = element.name.partition("/")
        return BodyJointDrive(joint, table.world.body(owner).model.joints[name].prismatic)
    prismatic = table.family.robot_joint(element.name).kind == "prismatic"
    index = int(element.name.rpartition("joint")[2]) - 1
    return RobotJointDrive(FingerMotors() if "_gripper_" in element.name else ArmMotors(), index, prismatic)
