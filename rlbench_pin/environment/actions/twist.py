"""Arm actions that name a tip velocity; every one goes through a QP that keeps the joint limits."""

from __future__ import annotations

from typing import Literal

import numpy as np

from rlbench_pin.control.differential_ik import DifferentialIK, DifferentialIKConfig
from rlbench_pin.environment.actions.arm_mode import FrameChoice, RelativeFrame, SpecifiedMode, as_frame
from rlbench_pin.environment.actions.specification import TWIST_NAMES, TWIST_UNITS, ActionSpec
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray


class EndEffectorVelocity(SpecifiedMode):
    """Tip velocity `[linear, angular]` (6,) for one tick, or a change of the present one; then the arm stops.

    Args:
        absolute_mode: A velocity; otherwise a difference to the present tip velocity.
        frame: Axes of the velocity: of the world, or of the tip.
    """

    def __init__(self, absolute_mode: bool = True, frame: FrameChoice = RelativeFrame.WORLD) -> None:
        self.absolute_mode, self.frame = absolute_mode, as_frame(frame)
        self._solver: DifferentialIK | None = None

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """Linear, then angular velocity."""
        high = np.repeat([runtime.description.linear_speed, runtime.description.angular_speed], 3)
        return ActionSpec(TWIST_NAMES, TWIST_UNITS, -high, high, "end effector" if self.frame is RelativeFrame.EE else "world", 1)

    def action(self, runtime: Runtime, action: FloatArray) -> None:
        """Solve for joint velocities and move for one tick."""
        twist = self.check(runtime, action)
        axes: Literal["tip", "world"] = "tip" if self.frame is RelativeFrame.EE else "world"
        q, v = runtime.robot.joint_positions, runtime.robot.joint_velocities
        if not self.absolute_mode:
            twist += runtime.model.jacobian(q, axes) @ v
        runtime.robot.set_velocity_targets(self._solver_for(runtime).velocity_for_twist(q, v, twist, axes))
        runtime.step()
        runtime.robot.set_velocity_targets(np.zeros(runtime.model.size))

    def _solver_for(self, runtime: Runtime) -> DifferentialIK:
        """Return the solver of this arm, made on first use."""
        if self._solver is None or self._solver.model is not runtime.model:
            self._solver = DifferentialIK(runtime.model, DifferentialIKConfig(dt=runtime.world.control_dt))
        return self._solver
