"""Motors of the arm."""

from __future__ import annotations

import numpy as np

from rlbench_pin.compat.motors.motors import Asked, Numbers, vector
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray, compose


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
        self._asked.velocities = vector(velocities, self._runtime.model.size, "joint velocities")
        self._drive()

    def set_forces(self, forces: Numbers) -> None:
        """Cap the motors' torques (n,) [N m].

        A cap counts where the velocity that was asked for is beyond the joint's limit: then it is the torque that acts, towards
        that velocity. Motors that follow positions or reachable velocities use the force that they need.
        """
        self._asked.forces = np.abs(vector(forces, self._runtime.model.size, "joint forces"))
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
        """What was asked of the arm: no velocity at first, and all the force that the motors have."""
        runtime = self._runtime
        return runtime.kept(ArmMotors, lambda: Asked(np.zeros(runtime.model.size), runtime.robot.effort_limits.copy()))

    def _drive(self) -> None:
        """Command what was asked: torques where velocities out of reach meet capped forces, otherwise velocities."""
        robot, asked = self._runtime.robot, self._asked
        out_of_reach = bool((np.abs(asked.velocities) > robot.velocity_limits).any())
        if out_of_reach and bool((asked.forces < robot.effort_limits).any()):
            robot.set_torques(np.sign(asked.velocities) * asked.forces)
        else:
            robot.set_velocity_targets(asked.velocities)
