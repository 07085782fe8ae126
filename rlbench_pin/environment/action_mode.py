"""Whole action modes: an arm mode and a gripper mode together."""

from __future__ import annotations

from rlbench_pin.environment.action_spec import ActionSpec
from rlbench_pin.environment.arm_actions import ArmActionMode, as_action
from rlbench_pin.environment.gripper_actions import GripperActionMode, GripperJointPosition
from rlbench_pin.environment.joint_actions import JointPosition
from rlbench_pin.environment.scene import Scene
from rlbench_pin.spatial import FloatArray

DELTA_LIMIT = 0.1
"""Largest joint difference of `JointPositionActionMode` [rad]."""


class ActionMode:
    """An arm mode and a gripper mode; subclasses say how they share one array.

    Args:
        arm_action_mode: What the first numbers do.
        gripper_action_mode: What the last numbers do.
    """

    def __init__(self, arm_action_mode: ArmActionMode, gripper_action_mode: GripperActionMode) -> None:
        self.arm_action_mode, self.gripper_action_mode = arm_action_mode, gripper_action_mode

    def action(self, scene: Scene, action: object) -> None:
        """Run one action to its end."""
        raise NotImplementedError

    def action_spec(self, scene: Scene) -> ActionSpec:
        """Return what the numbers mean: the arm's, then the gripper's."""
        return self.arm_action_mode.action_spec(scene).joined(self.gripper_action_mode.action_spec(scene))

    def action_shape(self, scene: Scene) -> int:
        """Return how many numbers an action has."""
        return self.arm_action_mode.action_shape(scene)[0] + self.gripper_action_mode.action_shape(scene)[0]

    def action_bounds(self, scene: Scene) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values, each of shape (n,)."""
        spec = self.action_spec(scene)
        return spec.low.copy(), spec.high.copy()

    def split(self, scene: Scene, action: object) -> tuple[FloatArray, FloatArray]:
        """Return the arm's and the gripper's numbers, checked, so that a refused action changes nothing."""
        values = as_action(action, self.action_shape(scene), type(self).__name__)
        size = self.arm_action_mode.action_shape(scene)[0]
        check = getattr(self.gripper_action_mode, "check", None)
        if check is not None:
            check(scene, values[size:])
        return values[:size], values[size:]


class MoveArmThenGripper(ActionMode):
    """The arm action runs to its end, then the gripper action."""

    def action(self, scene: Scene, action: object) -> None:
        """Move the arm, then the gripper."""
        arm, gripper = self.split(scene, action)
        self.arm_action_mode.action(scene, arm)
        self.gripper_action_mode.action(scene, gripper)


class JointPositionActionMode(ActionMode):
    """Joint differences [rad] and an absolute finger position [m], both within one control tick."""

    def __init__(self) -> None:
        self._arm, self._gripper = JointPosition(absolute_mode=False), GripperJointPosition()
        super().__init__(self._arm, self._gripper)

    def action_spec(self, scene: Scene) -> ActionSpec:
        """As both modes say, with joint differences of at most 0.1 rad, in one tick."""
        spec = super().action_spec(scene)
        low, high = spec.low.copy(), spec.high.copy()
        low[:-1], high[:-1] = -DELTA_LIMIT, DELTA_LIMIT
        return ActionSpec(spec.names, spec.units, low, high, spec.frame, 1)

    def action(self, scene: Scene, action: object) -> None:
        """Command both, step once, hold both."""
        arm, gripper = self.split(scene, action)
        self._arm.command(scene, arm)
        self._gripper.command(scene, gripper)
        scene.step()
        self._arm.after(scene)
        self._gripper.after(scene)
