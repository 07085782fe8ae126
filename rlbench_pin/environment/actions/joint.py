"""Arm actions in joint space: velocity, position and torque, absolute or relative. One action is one control tick."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment.actions.mode import PartMode
from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_flag


class JointMode(PartMode):
    """What modes with one number per arm joint share.

    Args:
        absolute_mode: The numbers are values; otherwise differences to what is measured.
    """

    unit = ""

    def __init__(self, absolute_mode: bool = True) -> None:
        self.absolute_mode = as_flag(absolute_mode, "absolute_mode")

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values."""
        raise NotImplementedError

    def make_spec(self, runtime: Runtime) -> ActionSpec:
        """One number per arm joint."""
        names = runtime.description.arm_joints
        low, high = self.bounds(runtime)
        return ActionSpec(names, (self.unit,) * len(names), low, high, "joint", 1)


class JointVelocity(JointMode):
    """Joint velocities [rad/s], or changes of the measured ones, for one tick; then the arm stops.

    Velocities beyond the limits are capped.
    """

    unit = "rad/s"

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Velocity limits of the joints."""
        limit = runtime.model.limits.velocity
        return -limit, limit

    def action_pre_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Set velocity targets."""
        runtime.robot.set_velocity_targets(action if self.absolute_mode else runtime.robot.joint_velocities + action)

    def action_post_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Command zero velocity."""
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))


class JointPosition(JointMode):
    """Joint positions [rad], or changes of the measured ones: one tick towards them, then hold.

    Positions beyond a joint limit mean the limit; the arm goes as far as the velocity limits allow in the tick.
    """

    unit = "rad"

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Joint limits; for differences what the velocity limits allow in one tick."""
        limits = runtime.model.limits
        if self.absolute_mode:
            return limits.lower, limits.upper
        step = limits.velocity * runtime.world.control_dt
        return -step, step

    def action_pre_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Set position targets."""
        runtime.robot.set_position_targets(action if self.absolute_mode else runtime.robot.joint_positions + action)

    def action_post_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Hold what is measured."""
        runtime.hold()


class JointTorque(JointMode):
    """Joint torques [N m] for one tick, gravity included, or changes of the motors' last torques; then the arm stops.

    Torques beyond the limits are capped. Joint positions are not limited: torques can drive a joint through its stop, which gives
    way, and to speeds beyond its limit; keep away from both in the policy, or use another mode with `SafeArm` around it.
    Between two torque actions nothing stops: the arm brakes in ticks that no torque action commands, as while the hand moves.
    """

    unit = "N m"

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Effort limits of the joints."""
        limit = runtime.model.limits.effort
        return -limit, limit

    def action_pre_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Set torques."""
        runtime.robot.set_torques(action if self.absolute_mode else runtime.robot.joint_torques + action)

    def action_post_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Command zero velocity, so that no torque acts on unwatched; the next action finds the arm as fast as it is."""
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))
