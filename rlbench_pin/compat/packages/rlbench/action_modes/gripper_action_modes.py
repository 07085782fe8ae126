"""What the numbers for the hand mean."""

from __future__ import annotations

import numpy as np

from rlbench.backend.exceptions import InvalidActionError
from rlbench_pin.compat.actions import ScenePart, UserMode, assert_action_shape
from rlbench_pin.compat.unwrap import SceneLike, runtime_of
from rlbench_pin.environment.actions import gripper as native
from rlbench_pin.environment.motion import hold_or_release
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.spatial import FloatArray

__all__ = ["Discrete", "GripperActionMode", "GripperJointPosition", "InvalidActionError", "assert_action_shape"]


class GripperActionMode(UserMode):
    """Turns numbers into motion of the hand. Derive from it, or from one of the classes below."""


class HandPart(ScenePart, native.GripperMode):
    """What modes of the hand share: their settings by the names that derived classes know."""

    @property
    def _attach_grasped_objects(self) -> bool:
        return self.attach_grasped_objects is not False

    @_attach_grasped_objects.setter
    def _attach_grasped_objects(self, value: bool) -> None:
        self.attach_grasped_objects = value

    @property
    def _detach_before_open(self) -> bool:
        return self.detach_before_open

    @_detach_before_open.setter
    def _detach_before_open(self, value: bool) -> None:
        self.detach_before_open = value


class Discrete(HandPart, native.Discrete, GripperActionMode):
    """One number, any finite one: above 0.5 opens the hand, otherwise closes it. Does nothing when the hand is already as asked.

    Args:
        attach_grasped_objects: Fix graspable objects between the fingers to the hand; None leaves it to the environment.
        detach_before_open: Let go before the fingers open; otherwise after.
    """

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the number as it is: networks deliver values beyond 0 and 1, and they mean shut and open as well."""
        return values

    def action(self, scene: SceneLike, action: object) -> None:
        """Open or close until the fingers stand.

        Raises:
            InvalidActionError: The action is refused; nothing has moved.
        """
        self.steps(runtime_of(scene), self.values(scene, action))

    def action_pre_step(self, scene: SceneLike, action: object) -> None:
        """Send the fingers on their way, for modes that step the simulation themselves."""
        runtime, wants_open = runtime_of(scene), bool(self.values(scene, action)[0] > 0.5)
        if wants_open and self.detach_before_open:
            runtime.gripper.release()
        goal = 1.0 if wants_open else 0.0
        if not runtime.gripper.grasped and not np.allclose(
            runtime.gripper.control.target, goal * runtime.description.gripper_open
        ):
            runtime.gripper.set_target(goal, runtime.description.finger_speed)

    def action_step(self, scene: SceneLike, action: object) -> None:
        """Step the simulation once."""
        scene.step()

    def action_post_step(self, scene: SceneLike, action: object) -> None:
        """Let go, or fix to the hand what stopped the fingers."""
        runtime, wants_open = runtime_of(scene), bool(self.values(scene, action)[0] > 0.5)
        stands = not runtime.gripper.moving
        hold_or_release(runtime, release=wants_open, attach=self.attaches(runtime) and stands)

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int]:
        """Return the shape of an action, (1,)."""
        return (1,)


class GripperJointPosition(HandPart, native.GripperJointPosition, GripperActionMode):
    """One number: the position of both fingers [m], or its change, for one step; then the fingers hold.

    Args:
        attach_grasped_objects: Fix graspable objects to the hand once the fingers can close no further; None leaves it to the
            environment.
        detach_before_open: Let go before the fingers open; otherwise after.
        absolute_mode: A position; otherwise a difference to the measured one.
    """

    def action_pre_step(self, scene: SceneLike, action: object) -> None:
        """Command the fingers."""
        runtime = runtime_of(scene)
        self.pre_step(runtime, self.values(scene, action))
        if runtime.robot.mode == "torque":
            runtime.hold()

    def action_step(self, scene: SceneLike, action: object) -> None:
        """Step the simulation once."""
        scene.step()

    def action_post_step(self, scene: SceneLike, action: object) -> None:
        """Attach what stopped the fingers, or let go; then hold."""
        self.post_step(runtime_of(scene), self.values(scene, action))

    def action_shape(self, scene: SceneLike | None = None) -> tuple[int]:
        """Return the shape of an action, (1,)."""
        return (1,)
