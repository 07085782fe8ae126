"""Whole action modes: an arm mode and a gripper mode together."""

from __future__ import annotations

import numpy as np

from rlbench_pin.environment.actions.arm_mode import ArmActionMode
from rlbench_pin.environment.actions.gripper import GripperActionMode, GripperJointPosition
from rlbench_pin.environment.actions.joint import JointPosition
from rlbench_pin.environment.actions.mode import PartMode, SpecifiedMode, as_action, checked, execute
from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray

DELTA_LIMIT = 0.1
"""Largest joint difference of `JointPositionActionMode` [rad]."""


class ActionMode(SpecifiedMode):
    """An arm mode and a gripper mode; subclasses say how they share one array.

    One object may serve several environments: what belongs to one of them is kept by its runtime.

    Args:
        arm_action_mode: What the first numbers do.
        gripper_action_mode: What the last numbers do.
    """

    def __init__(self, arm_action_mode: ArmActionMode, gripper_action_mode: GripperActionMode) -> None:
        self.arm_action_mode, self.gripper_action_mode = arm_action_mode, gripper_action_mode

    def action(self, runtime: Runtime, action: object) -> None:
        """Run one action to its end."""
        raise NotImplementedError

    def make_spec(self, runtime: Runtime) -> ActionSpec:
        """Work out what the numbers mean: the arm's, then the gripper's."""
        return self.arm_action_mode.action_spec(runtime).joined(self.gripper_action_mode.action_spec(runtime))

    def spec_origin(self, runtime: Runtime) -> tuple[object, ...]:
        """Return what `make_spec` depends on: the settings, and what both modes say."""
        return (
            *super().spec_origin(runtime),
            self.arm_action_mode.action_spec(runtime),
            self.gripper_action_mode.action_spec(runtime),
        )

    def action_shape(self, runtime: Runtime) -> int:
        """Return how many numbers an action has."""
        return self.arm_action_mode.action_shape(runtime)[0] + self.gripper_action_mode.action_shape(runtime)[0]

    def split(self, runtime: Runtime, action: object) -> tuple[FloatArray, FloatArray]:
        """Check an action, so that a refused one changes nothing, and return the arm's and the gripper's numbers.

        Numbers that the arm mode takes beyond its specification come last in the action and in the arm's numbers.

        Raises:
            InvalidActionError: The shape is wrong, a number is not finite, or the arm or gripper mode refuses its numbers.
        """
        size = self.arm_action_mode.action_shape(runtime)[0]
        whole = size + self.gripper_action_mode.action_shape(runtime)[0]
        more = self.arm_action_mode.optional_values if isinstance(self.arm_action_mode, PartMode) else 0
        values = as_action(action, whole, type(self).__name__, more)
        arm, gripper = np.concatenate([values[:size], values[whole:]]), values[size:whole]
        return checked(self.arm_action_mode, runtime, arm), checked(self.gripper_action_mode, runtime, gripper)


class MoveArmThenGripper(ActionMode):
    """The arm action runs to its end, then the gripper action. What ends the episode ends the action.

    With `EndEffectorPoseViaPlanning` a ninth number may follow the gripper's: 1 plans without collision checks, 0 with them.
    """

    def action(self, runtime: Runtime, action: object) -> None:
        """Move the arm, then the gripper."""
        arm, gripper = self.split(runtime, action)
        execute(self.arm_action_mode, runtime, arm)
        if not runtime.over:
            execute(self.gripper_action_mode, runtime, gripper)


class JointPositionActionMode(ActionMode):
    """Joint differences [rad] and an absolute finger position [m], both within one control tick."""

    def __init__(self) -> None:
        self._arm, self._gripper = JointPosition(absolute_mode=False), GripperJointPosition()
        super().__init__(self._arm, self._gripper)

    def make_spec(self, runtime: Runtime) -> ActionSpec:
        """As both modes say, with joint differences of at most 0.1 rad, in one tick."""
        spec = super().make_spec(runtime)
        low, high = spec.low.copy(), spec.high.copy()
        low[:-1], high[:-1] = -DELTA_LIMIT, DELTA_LIMIT
        return ActionSpec(spec.names, spec.units, low, high, spec.frame, 1)

    def action(self, runtime: Runtime, action: object) -> None:
        """Command both, step once, hold both."""
        arm, gripper = self.split(runtime, action)
        self._arm.action_pre_step(runtime, arm)
        self._gripper.action_pre_step(runtime, gripper)
        runtime.step()
        self._arm.action_post_step(runtime, arm)
        self._gripper.action_post_step(runtime, gripper)
