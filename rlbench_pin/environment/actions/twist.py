"""Arm actions that name a tip velocity; every one goes through a QP that keeps the joint limits."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig
from rlbench_pin.environment.actions.arm_mode import FrameChoice, RelativeFrame, as_frame
from rlbench_pin.environment.actions.mode import BoundMode, PartMode
from rlbench_pin.environment.actions.specification import TWIST_NAMES, TWIST_UNITS, ActionSpec
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_flag


@dataclass
class BoundVelocity(BoundMode):
    """A tip velocity mode in one runtime."""

    solver: DifferentialIK = field(kw_only=True)


class EndEffectorVelocity(PartMode):
    """Tip velocity `[linear, angular]` (6,) for one tick, or a change of the present one; then the arm stops.

    Joint limits come first: where the velocity cannot be had without breaking one, the arm follows as well as it can.

    Args:
        absolute_mode: A velocity; otherwise a difference to the present tip velocity.
        frame: Axes of the velocity: of the world, or of the tip.
    """

    def __init__(self, absolute_mode: bool = True, frame: FrameChoice = RelativeFrame.WORLD) -> None:
        self.absolute_mode, self.frame = as_flag(absolute_mode, "absolute_mode"), as_frame(frame)

    def bind(self, runtime: Runtime) -> BoundVelocity:
        """Make the solver of this arm and tick."""
        return BoundVelocity(solver=DifferentialIK(runtime.model, DifferentialIKConfig(dt=runtime.world.control_dt)))

    def make_spec(self, runtime: Runtime) -> ActionSpec:
        """Linear, then angular velocity."""
        high = np.repeat([runtime.description.linear_speed, runtime.description.angular_speed], 3)
        return ActionSpec(TWIST_NAMES, TWIST_UNITS, -high, high, "end effector" if self.frame is RelativeFrame.EE else "world", 1)

    def action_pre_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Solve for joint velocities and command them."""
        axes: Literal["tip", "world"] = "tip" if self.frame is RelativeFrame.EE else "world"
        q, v = runtime.robot.joint_positions, runtime.robot.joint_velocities
        if not self.absolute_mode:
            action = action + runtime.model.jacobian(q, axes) @ v
        runtime.robot.set_velocity_targets(runtime.bound(self).solver.velocity_for_twist(q, v, action, axes))

    def action_post_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Command zero velocity."""
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))
