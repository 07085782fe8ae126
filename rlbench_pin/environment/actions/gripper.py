"""Gripper action modes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from rlbench_pin.environment.actions.mode import ActionPart, BoundMode, PartMode
from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.motion import hold_or_release, move_gripper
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_flag


class GripperActionMode(ActionPart, Protocol):
    """Turns numbers into finger motion."""


class GripperMode(PartMode):
    """What gripper modes share.

    Args:
        attach_grasped_objects: Fix graspable bodies between the fingers to the hand; None leaves it to the environment.
        detach_before_open: Release before the fingers open; otherwise after.
    """

    def __init__(self, attach_grasped_objects: bool | None = None, detach_before_open: bool = True) -> None:
        if attach_grasped_objects is not None:
            attach_grasped_objects = as_flag(attach_grasped_objects, "attach_grasped_objects")
        self.attach_grasped_objects = attach_grasped_objects
        self.detach_before_open = as_flag(detach_before_open, "detach_before_open")

    def attaches(self, runtime: Runtime) -> bool:
        """Whether bodies are fixed to the hand."""
        return runtime.attach_grasped_objects if self.attach_grasped_objects is None else self.attach_grasped_objects


class Discrete(GripperMode):
    """One number: above 0.5 opens the hand, otherwise closes it. Does nothing when the hand is already as asked.

    A number below 0 or above 1 is refused.
    """

    def make_spec(self, runtime: Runtime) -> ActionSpec:
        """From 0, closed, to 1, open."""
        return ActionSpec(("gripper",), ("1",), np.zeros(1), np.ones(1), "joint", None)

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the number, or raise InvalidActionError when it does not lie between 0 and 1."""
        if not 0.0 <= values[0] <= 1.0:
            raise InvalidActionError(
                f"The gripper action is {values[0]}; it must lie between 0 (closed) and 1 (open).", "gripper out of range"
            )
        return values

    def execute(self, runtime: Runtime, values: FloatArray) -> None:
        """Open or close when that changes something."""
        wants_open = bool(values[0] > 0.5)
        if wants_open == runtime.gripper.is_open:
            return
        arm = runtime.description
        move_gripper(
            runtime,
            1.0 if wants_open else 0.0,
            release=wants_open,
            speed=arm.grip_speed if not wants_open and runtime.gripper.closes_on_something() else arm.finger_speed,
            attach=self.attaches(runtime),
            detach_before_open=self.detach_before_open,
        )


@dataclass(frozen=True)
class FingerMove:
    """A finger motion of one tick."""

    target: float
    """Commanded position of the fingers [m]."""
    opens: bool
    """Whether that is farther open than they were."""


@dataclass
class BoundFingers(BoundMode):
    """A finger position mode in one runtime."""

    move: FingerMove | None = field(default=None, init=False)
    """The motion of the present tick, from `action_pre_step` to `action_post_step`."""


class GripperJointPosition(GripperMode):
    """One number: the position of both fingers [m], or its change, for one tick; then the fingers hold.

    Positions beyond the range of a finger mean its end.

    Args:
        attach_grasped_objects: Fix graspable bodies between the fingers once they can close no further.
        detach_before_open: Release before the fingers open; otherwise after.
        absolute_mode: A position; otherwise a difference to the measured one.
    """

    def __init__(
        self, attach_grasped_objects: bool | None = None, detach_before_open: bool = True, absolute_mode: bool = True
    ) -> None:
        super().__init__(attach_grasped_objects, detach_before_open)
        self.absolute_mode = as_flag(absolute_mode, "absolute_mode")

    def make_spec(self, runtime: Runtime) -> ActionSpec:
        """From 0, shut, to the range of a finger; differences span it both ways."""
        high = np.array([runtime.description.gripper_open])
        return ActionSpec(("finger",), ("m",), np.zeros(1) if self.absolute_mode else -high, high, "joint", 1)

    def bind(self, runtime: Runtime) -> BoundFingers:
        """Keep the motion between the hooks of an action."""
        return BoundFingers()

    def action_pre_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Command the finger motors, without stepping; opening lets go."""
        here, reach = runtime.robot.fingers, runtime.description.gripper_open
        target = float(np.clip(action[0] if self.absolute_mode else here.mean() + action[0], 0.0, reach))
        opens = bool(target > here.mean() + 1e-4)
        if opens and self.detach_before_open:
            runtime.gripper.release()
        if not runtime.gripper.grasped or opens:
            runtime.gripper.set_target(target / reach, runtime.description.finger_speed)
        runtime.bound(self).move = FingerMove(target, opens)

    def action_step(self, runtime: Runtime, action: FloatArray) -> None:
        """One tick, in which the arm holds still."""
        if runtime.robot.mode == "torque":
            runtime.hold()
        runtime.step()

    def action_post_step(self, runtime: Runtime, action: FloatArray) -> None:
        """Attach what stopped the fingers, or let go; then hold.

        Raises:
            InvalidActionError: No `action_pre_step` came before.
        """
        bound = runtime.bound(self)
        move, bound.move = bound.move, None
        if move is None:
            raise InvalidActionError("`action_post_step` of the fingers was called without `action_pre_step`. Call that first.")
        stalled = runtime.robot.fingers.mean() > move.target + 1e-3 and not runtime.gripper.moving
        hold_or_release(runtime, release=move.opens, attach=self.attaches(runtime) and stalled)
        runtime.gripper.hold()
