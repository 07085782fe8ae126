"""Arm modes of one control tick: velocity, position and torque of the joints, and velocity of the tip."""

from __future__ import annotations

from typing import Literal

import numpy as np

from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig
from rlbench_pin.environment.actions.gripper import GripperJointPosition
from rlbench_pin.environment.actions.mode import (
    TWIST_NAMES,
    TWIST_UNITS,
    ActionMode,
    ActionSpec,
    ArmActionMode,
    FrameChoice,
    RelativeFrame,
    as_frame,
)
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_flag

DELTA_LIMIT = 0.1
"""Largest joint difference of `JointPositionActionMode` [rad]."""


class JointMode(ArmActionMode):
    """Base class of modes with one number per arm joint; subclasses override `bounds`.

    Args:
        absolute_mode: The numbers are values; otherwise differences to what is measured.
    """

    unit = ""
    ticks = 1

    def __init__(self, absolute_mode: bool = True) -> None:
        self.absolute_mode = as_flag(absolute_mode, "absolute_mode")

    def shape(self, runtime: Runtime) -> tuple[int]:
        """One number per arm joint."""
        return (runtime.model.size,)

    def spec(self, runtime: Runtime) -> ActionSpec:
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

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Set velocity targets."""
        runtime.robot.set_velocity_targets(values if self.absolute_mode else runtime.robot.joint_velocities + values)

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
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

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Set position targets."""
        runtime.robot.set_position_targets(values if self.absolute_mode else runtime.robot.joint_positions + values)

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Hold what is measured."""
        runtime.hold()


class JointTorque(JointMode):
    """Joint torques [N m] for one tick, gravity included, or changes of the motors' last torques; then the arm stops.

    Torques beyond the limits are capped. Joint positions are not limited: torques can drive a joint through its stop, which gives
    way, and to speeds beyond its limit; keep away from both in the policy, or use another mode with `SafeArm` around it.
    Between two torque actions nothing stops: the arm brakes in ticks that no torque action commands, as while the gripper moves.
    """

    unit = "N m"

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Effort limits of the joints."""
        limit = runtime.model.limits.effort
        return -limit, limit

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Set torques."""
        runtime.robot.set_torques(values if self.absolute_mode else runtime.robot.joint_torques + values)

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command zero velocity, so that no torque acts on unwatched; the next action finds the arm as fast as it is."""
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))


class EndEffectorVelocity(ArmActionMode):
    """Tip velocity `[linear, angular]` (6,) for one tick, or a change of the present one; then the arm stops.

    Joint limits come first: where the velocity cannot be had without breaking one, the arm follows as well as it can.

    Args:
        absolute_mode: A velocity; otherwise a difference to the present tip velocity.
        frame: Axes of the velocity: of the world, or of the tip.
    """

    ticks = 1

    def __init__(self, absolute_mode: bool = True, frame: FrameChoice = RelativeFrame.WORLD) -> None:
        self.absolute_mode, self.frame = as_flag(absolute_mode, "absolute_mode"), as_frame(frame)

    def shape(self, runtime: Runtime) -> tuple[int]:
        """Six numbers."""
        return (6,)

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Linear, then angular velocity."""
        high = np.repeat([runtime.description.linear_speed, runtime.description.angular_speed], 3)
        return ActionSpec(TWIST_NAMES, TWIST_UNITS, -high, high, "end effector" if self.frame is RelativeFrame.EE else "world", 1)

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Solve for joint velocities and command them."""
        axes: Literal["tip", "world"] = "tip" if self.frame is RelativeFrame.EE else "world"
        q, v = runtime.robot.joint_positions, runtime.robot.joint_velocities
        if not self.absolute_mode:
            values = values + runtime.model.jacobian(q, axes) @ v
        config = DifferentialIKConfig(dt=runtime.world.control_dt)
        solver = runtime.kept(self, lambda: DifferentialIK(runtime.model, config))
        runtime.robot.set_velocity_targets(solver.velocity_for_twist(q, v, values, axes))

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command zero velocity."""
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))


class JointPositionActionMode(ActionMode):
    """Joint differences [rad] and an absolute finger position [m], both within one control tick."""

    ticks = 1

    def __init__(self) -> None:
        super().__init__(JointPosition(absolute_mode=False), GripperJointPosition())

    def spec(self, runtime: Runtime) -> ActionSpec:
        """As both modes say, with joint differences of at most 0.1 rad, in one tick."""
        spec = super().spec(runtime)
        low, high = spec.low.copy(), spec.high.copy()
        low[:-1], high[:-1] = -DELTA_LIMIT, DELTA_LIMIT
        return ActionSpec(spec.names, spec.units, low, high, spec.frame, 1)

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command both."""
        self.arm_action_mode.pre_step(runtime, values[:-1])
        self.gripper_action_mode.pre_step(runtime, values[-1:])

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Hold both."""
        self.arm_action_mode.post_step(runtime, values[:-1])
        self.gripper_action_mode.post_step(runtime, values[-1:])
