"""Arm actions in joint space: velocity, position and torque, absolute or relative. One action is one control tick."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment.action_spec import ActionSpec
from rlbench_pin.environment.arm_actions import SpecifiedMode
from rlbench_pin.environment.scene import Scene
from rlbench_pin.spatial import FloatArray


class JointMode(SpecifiedMode):
    """What modes with one number per arm joint share.

    Args:
        absolute_mode: The numbers are values; otherwise differences to what is measured.
    """

    unit = ""

    def __init__(self, absolute_mode: bool = True) -> None:
        self.absolute_mode = absolute_mode

    def bounds(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values."""
        raise NotImplementedError

    def command(self, scene: Scene, values: FloatArray) -> None:
        """Tell the motors, without stepping."""
        raise NotImplementedError

    def after(self, scene: Scene) -> None:
        """Leave the arm at rest after the tick."""

    def action_spec(self, scene: Scene) -> ActionSpec:
        """One number per arm joint."""
        names = scene.description.arm_joints
        low, high = self.bounds(scene)
        return ActionSpec(names, (self.unit,) * len(names), low, high, "joint", 1)

    def action(self, scene: Scene, action: FloatArray) -> None:
        """Command, step once, come to rest."""
        self.command(scene, self.check(scene, action))
        scene.step()
        self.after(scene)


class JointVelocity(JointMode):
    """Joint velocities [rad/s], or changes of the measured ones, for one tick; then the arm stops."""

    unit = "rad/s"

    def bounds(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Velocity limits of the joints."""
        limit = scene.model.limits.velocity
        return -limit, limit

    def command(self, scene: Scene, values: FloatArray) -> None:
        """Set velocity targets."""
        scene.robot.set_velocity_targets(values if self.absolute_mode else scene.robot.joint_velocities + values)

    def after(self, scene: Scene) -> None:
        """Command zero velocity."""
        scene.robot.set_velocity_targets(np.zeros(scene.model.size))


class JointPosition(JointMode):
    """Joint positions [rad], or changes of the measured ones: one tick towards them, then hold."""

    unit = "rad"

    def bounds(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Joint limits; for differences what the velocity limits allow in one tick."""
        limits = scene.model.limits
        if self.absolute_mode:
            return limits.lower, limits.upper
        step = limits.velocity * scene.world.control_dt
        return -step, step

    def command(self, scene: Scene, values: FloatArray) -> None:
        """Set position targets."""
        scene.robot.set_position_targets(values if self.absolute_mode else scene.robot.joint_positions + values)

    def after(self, scene: Scene) -> None:
        """Hold what is measured."""
        scene.hold()


class JointTorque(JointMode):
    """Joint torques [N m] for one tick, gravity included, or changes of the motors' last torques; then the arm stops."""

    unit = "N m"

    def bounds(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Effort limits of the joints."""
        limit = scene.model.limits.effort
        return -limit, limit

    def command(self, scene: Scene, values: FloatArray) -> None:
        """Set torques."""
        scene.robot.set_torques(values if self.absolute_mode else scene.robot.joint_torques + values)

    def after(self, scene: Scene) -> None:
        """Nothing: the last torques act until the next action, or until the hand is to move."""
