"""Action modes of the robot: an arm mode and a gripper mode that share one array."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from rlbench.action_modes.arm_action_modes import ArmActionMode, JointPosition, takes_ignore_collisions
from rlbench.action_modes.gripper_action_modes import GripperActionMode, GripperJointPosition
from rlbench_pin.compat.actions import ScenePart
from rlbench_pin.compat.simulator import SceneLike
from rlbench_pin.environment.actions.modes import as_action
from rlbench_pin.robot import DEFAULT_ROBOT, robot_description
from rlbench_pin.spatial import FloatArray

__all__ = [
    "ActionMode",
    "ArmActionMode",
    "GripperActionMode",
    "GripperJointPosition",
    "JointPosition",
    "JointPositionActionMode",
    "MoveArmThenGripper",
]

Action = Sequence[float] | FloatArray
DELTA_LIMIT = 0.1
"""Largest joint difference of `JointPositionActionMode` [rad]."""


class ActionMode:
    """An arm mode and a gripper mode; subclasses define how they share one array.

    Args:
        arm_action_mode: Mode of the first values of an action.
        gripper_action_mode: Mode of the values after them.
    """

    def __init__(self, arm_action_mode: ArmActionMode, gripper_action_mode: GripperActionMode) -> None:
        self.arm_action_mode, self.gripper_action_mode = arm_action_mode, gripper_action_mode

    def action(self, scene: SceneLike, action: Action) -> None:
        """Execute one action to its end."""
        raise NotImplementedError(f"{type(self).__name__} needs a method `action(scene, action)`.")

    def action_shape(self, scene: SceneLike) -> int:
        """Return the number of values of an action."""
        raise NotImplementedError(f"{type(self).__name__} needs a method `action_shape(scene)` that returns a number.")

    def action_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of an action, each of shape (n,)."""
        raise NotImplementedError(f"{type(self).__name__} needs a method `action_bounds()` for this use, such as gymnasium.")


class MoveArmThenGripper(ActionMode):
    """Executes the arm action to its end, then the gripper action.

    For an arm mode with the argument `ignore_collisions`, an action may have an additional last value: if it is not 0, the
    action ignores collisions.
    """

    def action(self, scene: SceneLike, action: Action) -> None:
        """Move the arm, then the gripper.

        Raises:
            InvalidActionError: The action is invalid. With modes of this package, the robot has not moved.
        """
        arm, gripper, ignore_collisions = self._split(scene, action)
        require_accepted(scene, ((self.arm_action_mode, arm), (self.gripper_action_mode, gripper)))
        if ignore_collisions is None:
            self.arm_action_mode.action(scene, arm)
        else:
            self.arm_action_mode.action(scene, arm, ignore_collisions=ignore_collisions)  # type: ignore[call-arg]
        self.gripper_action_mode.action(scene, gripper)

    def action_shape(self, scene: SceneLike) -> int:
        """Return the number of values of an action, without the flag for collisions."""
        return int(np.prod(self.arm_action_mode.action_shape(scene))) + int(np.prod(self.gripper_action_mode.action_shape(scene)))

    def action_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds of an action in the current world, each of shape (n,): arm first, then gripper."""
        parts = (self.arm_action_mode.action_bounds(), self.gripper_action_mode.action_bounds())
        return np.concatenate([low for low, _ in parts]), np.concatenate([high for _, high in parts])

    def _split(self, scene: SceneLike, action: Action) -> tuple[FloatArray, FloatArray, bool | None]:
        """Return the values for the arm, the values for the gripper, and the flag for collisions, or None without a flag."""
        arm, gripper = (int(np.prod(part.action_shape(scene))) for part in (self.arm_action_mode, self.gripper_action_mode))
        size, count = arm + gripper, np.size(np.asarray(action, dtype=object))
        with_flag = count == size + 1 and takes_ignore_collisions(self.arm_action_mode)
        values = as_action(action, size + with_flag, type(self).__name__)
        return values[:arm], values[arm:size], bool(values[size]) if with_flag else None


class JointPositionActionMode(ActionMode):
    """Joint differences [rad] and an absolute finger position [m], both within one step."""

    def __init__(self) -> None:
        super().__init__(JointPosition(absolute_mode=False), GripperJointPosition(absolute_mode=True))

    def action(self, scene: SceneLike, action: Action) -> None:
        """Command arm and gripper, step once, then stop both.

        Raises:
            InvalidActionError: The action is invalid; the robot has not moved.
        """
        values = as_action(action, self.action_shape(scene), type(self).__name__)
        size = int(np.prod(self.arm_action_mode.action_shape(scene)))
        parts = ((self.arm_action_mode, values[:size]), (self.gripper_action_mode, values[size:]))
        require_accepted(scene, parts)
        for mode, numbers in parts:
            mode.action_pre_step(scene, numbers)
        scene.step()
        for mode, numbers in parts:
            mode.action_post_step(scene, numbers)

    def action_shape(self, scene: SceneLike | None = None) -> int:
        """Return the number of values of an action."""
        return len(robot_description(DEFAULT_ROBOT).arm_joints) + 1

    def action_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds: -0.1 and 0.1 rad for joints, the range of a finger [m] for the gripper."""
        arm = robot_description(DEFAULT_ROBOT)
        high = np.array([DELTA_LIMIT] * len(arm.arm_joints) + [arm.gripper_open])
        return np.append(-high[:-1], 0.0), high


Part = tuple[ArmActionMode | GripperActionMode, FloatArray]


def require_accepted(scene: SceneLike, parts: Iterable[Part]) -> None:
    """Raise InvalidActionError if the values of a mode of this package are invalid; modes of programs are not checked."""
    for mode, numbers in parts:
        if isinstance(mode, ScenePart):
            mode.values(scene, numbers)
