"""Gripper action modes."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from rlbench_pin.environment.actions.arm_mode import SpecifiedMode
from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.motion import hold_or_release, move_gripper
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import FloatArray


class GripperActionMode(Protocol):
    """Turns numbers into finger motion."""

    def action(self, runtime: Runtime, action: FloatArray) -> None:
        """Run one action to its end."""
        ...

    def action_shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action."""
        ...

    def action_bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action."""
        ...

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """Return what the numbers mean."""
        ...


class GripperMode(SpecifiedMode):
    """What gripper modes share.

    Args:
        attach_grasped_objects: Fix graspable bodies between the fingers to the hand; None leaves it to the environment.
        detach_before_open: Release before the fingers open; otherwise after.
    """

    def __init__(self, attach_grasped_objects: bool | None = None, detach_before_open: bool = True) -> None:
        self.attach_grasped_objects, self.detach_before_open = attach_grasped_objects, detach_before_open
        self.environment_attaches = True

    @property
    def attaches(self) -> bool:
        """Whether bodies are fixed to the hand."""
        return self.environment_attaches if self.attach_grasped_objects is None else self.attach_grasped_objects


class Discrete(GripperMode):
    """One number: above 0.5 opens the hand, otherwise closes it. Does nothing when the hand is already as asked."""

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """From 0, closed, to 1, open."""
        return ActionSpec(("gripper",), ("1",), np.zeros(1), np.ones(1), "joint", None)

    def check(self, runtime: Runtime, action: object) -> FloatArray:
        """Return the number, or raise InvalidActionError."""
        values = super().check(runtime, action)
        if not 0.0 <= values[0] <= 1.0:
            raise InvalidActionError(f"The gripper action is {values[0]}; it must lie between 0 (closed) and 1 (open).")
        return values

    def action(self, runtime: Runtime, action: FloatArray) -> None:
        """Open or close when that changes something."""
        wants_open = bool(self.check(runtime, action)[0] > 0.5)
        if wants_open == runtime.gripper.is_open:
            return
        arm = runtime.description
        move_gripper(
            runtime,
            1.0 if wants_open else 0.0,
            release=wants_open,
            speed=arm.grip_speed if not wants_open and runtime.gripper.closes_on_something() else arm.finger_speed,
            attach=self.attaches,
            detach_before_open=self.detach_before_open,
        )


class GripperJointPosition(GripperMode):
    """One number: the position of both fingers [m], or its change, for one tick; then the fingers hold.

    Args:
        attach_grasped_objects: Fix graspable bodies between the fingers once they can close no further.
        detach_before_open: Release before the fingers open; otherwise after.
        absolute_mode: A position; otherwise a difference to the measured one.
    """

    def __init__(
        self, attach_grasped_objects: bool | None = None, detach_before_open: bool = True, absolute_mode: bool = True
    ) -> None:
        super().__init__(attach_grasped_objects, detach_before_open)
        self.absolute_mode = absolute_mode

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """From 0, shut, to the range of a finger; differences span it both ways."""
        high = np.array([runtime.description.gripper_open])
        return ActionSpec(("finger",), ("m",), np.zeros(1) if self.absolute_mode else -high, high, "joint", 1)

    def command(self, runtime: Runtime, values: FloatArray) -> None:
        """Tell the finger motors, without stepping; opening lets go."""
        here, reach = runtime.robot.fingers, runtime.description.gripper_open
        target = float(np.clip(values[0] if self.absolute_mode else here.mean() + values[0], 0.0, reach))
        self._opens = target > here.mean() + 1e-4
        if self._opens and self.detach_before_open:
            runtime.gripper.release()
        if not runtime.gripper.grasped or self._opens:
            runtime.gripper.set_target(target / reach, runtime.description.finger_speed)
        self._wanted = target

    def after(self, runtime: Runtime) -> None:
        """Attach what stopped the fingers, or let go; then hold."""
        stalled = runtime.robot.fingers.mean() > self._wanted + 1e-3 and not runtime.gripper.moving
        hold_or_release(runtime, release=self._opens, attach=self.attaches and stalled)
        runtime.gripper.hold()

    def action(self, runtime: Runtime, action: FloatArray) -> None:
        """Command, step once, hold."""
        self.command(runtime, self.check(runtime, action))
        if runtime.robot.mode == "torque":
            runtime.hold()
        runtime.step()
        self.after(runtime)
