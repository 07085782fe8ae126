"""Motors of the hand."""

from __future__ import annotations

import numpy as np

from rlbench_pin.compat.motors.motors import Asked, Numbers, vector
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray


class FingerMotors:
    """Motors of the hand that runs now; a gear couples the fingers, so that they get the mean of what is asked."""

    @property
    def _runtime(self) -> Runtime:
        return Simulator.current().runtime

    @property
    def _count(self) -> int:
        return len(self._runtime.description.gripper_joints)

    @property
    def _asked(self) -> Asked:
        """What was asked of the fingers: no velocity at first, and the gripper's own force."""
        force = self._runtime.description.gripper_force
        return self._runtime.kept(FingerMotors, lambda: Asked(np.zeros(self._count), np.full(self._count, force)))

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
        states[0, fingers] = np.clip(vector(positions, self._count, "finger positions"), *self.limits())
        states[1, fingers] = 0.0
        runtime.robot.set_joint_states(states[0], states[1])
        runtime.gripper.hold()

    def target_positions(self) -> FloatArray:
        """Where the fingers go (2,) [m]."""
        return self._runtime.gripper.control.target.copy()

    def set_target_positions(self, positions: Numbers) -> None:
        """Go to finger positions (2,) [m]."""
        self._go(float(vector(positions, self._count, "finger positions").mean()), self._runtime.description.finger_speed)

    def target_velocities(self) -> FloatArray:
        """Finger velocities (2,) that were asked for [m/s]."""
        return self._asked.velocities.copy()

    def set_target_velocities(self, velocities: Numbers) -> None:
        """Open at a positive, close at a negative mean of velocities (2,) [m/s]; hold at zero."""
        asked = self._asked
        asked.velocities = vector(velocities, self._count, "finger velocities")
        speed = float(asked.velocities.mean())
        if speed == 0.0:
            self._runtime.gripper.hold()
        else:
            self._go(self._runtime.description.gripper_open if speed > 0.0 else 0.0, abs(speed))

    def set_forces(self, forces: Numbers) -> None:
        """Cap the fingers' forces (2,) [N], from the next motion on."""
        self._asked.forces = np.abs(vector(forces, self._count, "finger forces"))

    def control_loop(self) -> bool:
        """Always true: finger motors follow positions, at a given speed."""
        return True

    def set_control_loop(self, enabled: bool) -> None:
        """Nothing: target velocities move the fingers either way."""

    def open_to(self, amount: float, speed: float) -> None:
        """Go to an opening, 0 shut to 1 open, at a finger speed [m/s], with the force that was set."""
        self._runtime.gripper.set_target(amount, speed, float(self._asked.forces.mean()) or None)

    def _go(self, position: float, speed: float) -> None:
        self.open_to(float(np.clip(position / self._runtime.description.gripper_open, 0.0, 1.0)), speed)
