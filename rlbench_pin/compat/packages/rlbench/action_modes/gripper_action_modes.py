"""Action modes of the gripper."""

from __future__ import annotations

import numpy as np

from rlbench_pin.compat.actions import OneStepPart, UserMode, assert_action_shape, setting
from rlbench_pin.compat.simulator import SceneLike, runtime_of
from rlbench_pin.environment.actions import modes as native
from rlbench_pin.environment.runtime import Runtime, hold_or_release
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import FloatArray

__all__ = ["Discrete", "GripperActionMode", "GripperJointPosition", "InvalidActionError", "assert_action_shape"]


class GripperActionMode(UserMode):
    """Base class of gripper modes: converts the values of an action to motions of the gripper."""


class GripperPart(OneStepPart, native.GripperMode):
    """Settings of gripper modes, with the attribute names of RLBench."""

    @property
    def _attach_grasped_objects(self) -> bool:
        return self.attach_grasped_objects is not False

    @_attach_grasped_objects.setter
    def _attach_grasped_objects(self, value: bool) -> None:
        self.attach_grasped_objects = value

    _detach_before_open = setting("detach_before_open")

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int]:
        """Return the shape of an action, (1,)."""
        return (1,)


class Discrete(GripperPart, native.Discrete, GripperActionMode):
    """One finite number: above 0.5 it opens the gripper, otherwise it closes it; no effect in the requested state.

    Args:
        attach_grasped_objects: Fix graspable objects between the fingers to the gripper; None is the setting of the environment.
        detach_before_open: Release objects before the fingers open; otherwise after.
    """

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the value unchanged: values below 0 and above 1, which networks also return, mean closed and open."""
        return values

    def action(self, scene: SceneLike, action: object) -> None:
        """Open or close the fingers until they stop.

        Raises:
            InvalidActionError: The action is invalid; the fingers have not moved.
        """
        self.steps(runtime_of(scene), self.values(scene, action))

    def action_pre_step(self, scene: SceneLike, action: object) -> None:
        """Command the fingers, for action modes that step the simulation themselves."""
        runtime, wants_open = runtime_of(scene), bool(self.values(scene, action)[0] > 0.5)
        if wants_open and self.detach_before_open:
            runtime.gripper.release()
        goal = 1.0 if wants_open else 0.0
        if not runtime.gripper.grasped and not np.allclose(
            runtime.gripper.control.target, goal * runtime.description.gripper_open
        ):
            runtime.gripper.set_target(goal, runtime.description.finger_speed)

    def action_post_step(self, scene: SceneLike, action: object) -> None:
        """Release the held objects, or attach the object between the fingers once they have stopped."""
        runtime, wants_open = runtime_of(scene), bool(self.values(scene, action)[0] > 0.5)
        at_rest = not runtime.gripper.moving
        hold_or_release(runtime, release=wants_open, attach=self.attaches(runtime) and at_rest)


class GripperJointPosition(GripperPart, native.GripperJointPosition, GripperActionMode):
    """One number: the position of both fingers [m], or a difference, for one step; then the fingers stop.

    Args:
        attach_grasped_objects: Fix graspable objects to the gripper once the fingers can close no further; None is the setting
            of the environment.
        detach_before_open: Release objects before the fingers open; otherwise after.
        absolute_mode: Use a position; otherwise a difference to the measured one.
    """

    def action_pre_step(self, scene: SceneLike, action: object) -> None:
        """Command the fingers."""
        super().action_pre_step(scene, action)
        runtime = runtime_of(scene)
        if runtime.robot.mode == "torque":
            runtime.hold()
