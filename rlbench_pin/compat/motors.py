"""Joint motors of the arm and of the hand, as pyrep's robot components and joints command them.

Nothing is kept here but what our world has no word for: force caps, and the velocities that were asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray, compose

Numbers = Sequence[float] | FloatArray


class Motors(Protocol):
    """The motors of one component; every vector has one number per joint."""

    def positions(self) -> FloatArray:
        """Measured positions (n,) [rad] or [m]."""
        ...

    def velocities(self) -> FloatArray:
        """Measured velocities (n,) [rad/s] or [m/s]."""
        ...

    def forces(self) -> FloatArray:
        """Forces (n,) of the motors in the last physics step [N m] or [N]."""
        ...

    def limits(self) -> FloatArray:
        """Lowest and highest positions, shape (2, n), [rad] or [m]."""
        ...

    def velocity_limits(self) -> FloatArray:
        """Largest speeds (n,) [rad/s] or [m/s]."""
        ...

    def teleport(self, positions: Numbers) -> None:
        """Put the joints at positions (n,) [rad] or [m], at rest."""
        ...

    def target_positions(self) -> FloatArray:
        """Where the motors go (n,) [rad] or [m]."""
        ...

    def set_target_positions(self, positions: Numbers) -> None:
        """Go to positions (n,) [rad] or [m] in the coming ticks."""
        ...

    def target_velocities(self) -> FloatArray:
        """Velocities (n,) that were asked for [rad/s] or [m/s]."""
        ...

    def set_target_velocities(self, velocities: Numbers) -> None:
        """Move at velocities (n,) [rad/s] or [m/s] until the next command."""
        ...

    def set_forces(self, forces: Numbers) -> None:
        """Cap the motors' forces (n,) [N m] or [N]."""
        ...

    def control_loop(self) -> bool:
        """Whether positions are controlled."""
        ...

    def set_control_loop(self, enabled: bool) -> None:
        """Control positions; otherwise velocities, zero at first."""
        ...


@dataclass
class Asked:
    """What was asked of the motors of one runtime."""

    velocities: FloatArray
    """Target velocities (n,)."""
    forces: FloatArray
    """Force caps (n,)."""


@dataclass(frozen=True)
class AskedOfArm:
    """Keeps what was asked of the arm, with its runtime."""

    def bind(self, runtime: Runtime) -> Asked:
        """Start with no velocity and all the force that the motors have."""
        return Asked(np.zeros(runtime.model.size), runtime.robot.effort_limits.copy())


@dataclass(frozen=True)
class AskedOfFingers:
    """Keeps what was asked of the fingers, with its runtime."""

    def bind(self, runtime: Runtime) -> Asked:
        """Start with no velocity and the hand's own force."""
        count = len(runtime.description.gripper_joints)
        return Asked(np.zeros(count), np.full(count, runtime.description.gripper_force))


_ARM, _FINGERS = AskedOfArm(), AskedOfFingers()


class ArmMotors:
    """Motors of the arm that runs now."""

    @property
    def _runtime(self) -> Runtime:
        return Simulator.current().runtime

    def positions(self) -> FloatArray:
        """Measured joint positions (n,) [rad]."""
        return self._runtime.robot.joint_positions

    def velocities(self) -> FloatArray:
        """Measured joint velocities (n,) [rad/s]."""
        return self._runtime.robot.joint_velocities

    def forces(self) -> FloatArray:
        """Torques (n,) of the motors in the last physics step [N m]."""
        return self._runtime.robot.joint_torques

    def limits(self) -> FloatArray:
        """Lowest and highest joint positions, shape (2, n), [rad]."""
        return np.array([self._runtime.robot.lower, self._runtime.robot.upper])

    def velocity_limits(self) -> FloatArray:
        """Largest joint speeds (n,) [rad/s]."""
        return self._runtime.robot.velocity_limits.copy()

    def teleport(self, positions: Numbers) -> None:
        """Put the joints at positions (n,) [rad], at rest; what the hand holds comes along."""
        runtime = self._runtime
        runtime.robot.reset_configuration(np.asarray(positions, dtype=float))
        hand = runtime.robot.link_pose(runtime.description.hand_link)
        for held in runtime.gripper.attachments():
            runtime.world.body(held.body).set_pose(compose(hand, held.T_hand_body))

    def target_positions(self) -> FloatArray:
        """Where the joints go (n,) [rad]; without position control where they are."""
        control = self._runtime.robot.control
        return control.target.copy() if control.mode == "position" else self.positions()

    def set_target_positions(self, positions: Numbers) -> None:
        """Go to joint positions (n,) [rad], under position control from now on."""
        self._runtime.robot.set_position_targets(np.asarray(positions, dtype=float))

    def target_velocities(self) -> FloatArray:
        """Joint velocities (n,) that were asked for [rad/s]; under position control none are."""
        return self._asked.velocities.copy() if not self.control_loop() else np.zeros(self._runtime.model.size)

    def set_target_velocities(self, velocities: Numbers) -> None:
        """Turn the joints at velocities (n,) [rad/s], under velocity control from now on.

        Velocities beyond a joint's limit together with capped forces mean torques; see `set_forces`.
        """
        self._asked.velocities = _vector(velocities, self._runtime.model.size, "joint velocities")
        self._drive()

    def set_forces(self, forces: Numbers) -> None:
        """Cap the motors' torques (n,) [N m].

        A cap counts where the velocity that was asked for is beyond the joint's limit: then it is the torque that acts, towards
        that velocity. Motors that follow positions or reachable velocities use the force that they need.
        """
        self._asked.forces = np.abs(_vector(forces, self._runtime.model.size, "joint forces"))
        if not self.control_loop():
            self._drive()

    def control_loop(self) -> bool:
        """Whether joint positions are controlled."""
        return self._runtime.robot.mode == "position"

    def set_control_loop(self, enabled: bool) -> None:
        """Control positions, at first those measured; otherwise velocities, zero at first."""
        if enabled and not self.control_loop():
            self._runtime.hold()
        elif not enabled and self.control_loop():
            self.set_target_velocities(np.zeros(self._runtime.model.size))

    @property
    def _asked(self) -> Asked:
        return self._runtime.bound(_ARM)

    def _drive(self) -> None:
        """Command what was asked: torques where velocities out of reach meet capped forces, otherwise velocities."""
        robot, asked = self._runtime.robot, self._asked
        out_of_reach = bool((np.abs(asked.velocities) > robot.velocity_limits).any())
        if out_of_reach and bool((asked.forces < robot.effort_limits).any()):
            robot.set_torques(np.sign(asked.velocities) * asked.forces)
        else:
            robot.set_velocity_targets(asked.velocities)


class FingerMotors:
    """Motors of the hand that runs now; a gear couples the fingers, so that they get the mean of what is asked."""

    @property
    def _runtime(self) -> Runtime:
        return Simulator.current().runtime

    @property
    def _count(self) -> int:
        return len(self._runtime.description.gripper_joints)

    def positions(self) -> FloatArray:
        """Measured finger positions (2,) [m]."""
        return self._runtime.robot.fingers

    def velocities(self) -> FloatArray:
        """Measured finger velocities (2,) [m/s]."""
        return self._runtime.robot.joint_states()[1, self._runtime.model.size :]

    def forces(self) -> FloatArray:
        """Forces (2,) of the finger motors in the last physics step [N]."""
        return self._runtime.robot.joint_states()[2, self._runtime.model.size :]

    def limits(self) -> FloatArray:
        """Shut and open, shape (2, 2), [m]."""
        return np.array([np.zeros(self._count), np.full(self._count, self._runtime.description.gripper_open)])

    def velocity_limits(self) -> FloatArray:
        """Speeds (2,) of gripper actions [m/s]; faster ones may be asked for."""
        return np.full(self._count, self._runtime.description.finger_speed)

    def teleport(self, positions: Numbers) -> None:
        """Put the fingers at positions (2,) [m], at rest; the arm goes on as it was."""
        runtime = self._runtime
        states, fingers = runtime.robot.joint_states(), slice(runtime.model.size, None)
        states[0, fingers] = np.clip(_vector(positions, self._count, "finger positions"), *self.limits())
        states[1, fingers] = 0.0
        runtime.robot.set_joint_states(states[0], states[1])
        runtime.gripper.hold()

    def target_positions(self) -> FloatArray:
        """Where the fingers go (2,) [m]."""
        return self._runtime.gripper.control.target.copy()

    def set_target_positions(self, positions: Numbers) -> None:
        """Go to finger positions (2,) [m]."""
        self._go(float(_vector(positions, self._count, "finger positions").mean()), self._runtime.description.finger_speed)

    def target_velocities(self) -> FloatArray:
        """Finger velocities (2,) that were asked for [m/s]."""
        return self._runtime.bound(_FINGERS).velocities.copy()

    def set_target_velocities(self, velocities: Numbers) -> None:
        """Open at a positive, close at a negative mean of velocities (2,) [m/s]; hold at zero."""
        asked = self._runtime.bound(_FINGERS)
        asked.velocities = _vector(velocities, self._count, "finger velocities")
        speed = float(asked.velocities.mean())
        if speed == 0.0:
            self._runtime.gripper.hold()
        else:
            self._go(self._runtime.description.gripper_open if speed > 0.0 else 0.0, abs(speed))

    def set_forces(self, forces: Numbers) -> None:
        """Cap the fingers' forces (2,) [N], from the next motion on."""
        self._runtime.bound(_FINGERS).forces = np.abs(_vector(forces, self._count, "finger forces"))

    def control_loop(self) -> bool:
        """Always true: finger motors follow positions, at a given speed."""
        return True

    def set_control_loop(self, enabled: bool) -> None:
        """Nothing: target velocities move the fingers either way."""

    def open_to(self, amount: float, speed: float) -> None:
        """Go to an opening, 0 shut to 1 open, at a finger speed [m/s], with the force that was set."""
        self._runtime.gripper.set_target(amount, speed, float(self._runtime.bound(_FINGERS).forces.mean()) or None)

    def _go(self, position: float, speed: float) -> None:
        self.open_to(float(np.clip(position / self._runtime.description.gripper_open, 0.0, 1.0)), speed)


def robot_joint(name: str) -> tuple[Motors, int] | None:
    """Return the motors that a joint `Panda_joint3` or `Panda_gripper_joint1` belongs to, and its place; None for others."""
    description = Simulator.current().model.description
    arm, hand = f"{description.name}_joint", f"{description.name}_gripper_joint"
    choices: tuple[tuple[str, Motors, int], ...] = (
        (arm, ArmMotors(), len(description.arm_joints)),
        (hand, FingerMotors(), len(description.gripper_joints)),
    )
    for prefix, motors, count in choices:
        number = name[len(prefix) :]
        if name.lower().startswith(prefix) and number.isdigit() and 1 <= int(number) <= count:
            return motors, int(number) - 1
    return None


def _vector(numbers: Numbers, size: int, what: str) -> FloatArray:
    """Return `size` finite numbers, or raise ValueError."""
    vector = np.array(numbers, dtype=float)
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise ValueError(f"{what}: {size} finite numbers are needed, not {numbers!r}.")
    return vector
