"""Gripper action modes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rlbench_pin.environment.actions.mode import ActionSpec, GripperActionMode
from rlbench_pin.environment.motion import hold_or_release, move_gripper
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_flag


class GripperMode(GripperActionMode):
    """Base class of the gripper modes of this package.

    Args:
        attach_grasped_objects: Fix graspable bodies between the fingers to the gripper; None leaves it to the environment.
        detach_before_open: Release before the fingers open; otherwise after.
    """

    def __init__(self, attach_grasped_objects: bool | None = None, detach_before_open: bool = True) -> None:
        if attach_grasped_objects is not None:
            attach_grasped_objects = as_flag(attach_grasped_objects, "attach_grasped_objects")
        self.attach_grasped_objects = attach_grasped_objects
        self.detach_before_open = as_flag(detach_before_open, "detach_before_open")

    def attaches(self, runtime: Runtime) -> bool:
        """Whether bodies are fixed to the gripper."""
        return runtime.attach_grasped_objects if self.attach_grasped_objects is None else self.attach_grasped_objects


class Discrete(GripperMode):
    """One number: above 0.5 opens the gripper, otherwise closes it. Does nothing when the gripper is already as asked.

    A number below 0 or above 1 is refused.
    """

    def spec(self, runtime: Runtime) -> ActionSpec:
        """From 0, closed, to 1, open."""
        return ActionSpec(("gripper",), ("1",), np.zeros(1), np.ones(1), "joint", None)

    def shape(self, runtime: Runtime) -> tuple[int]:
        """One number."""
        return (1,)

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the number, or raise InvalidActionError when it does not lie between 0 and 1."""
        if not 0.0 <= values[0] <= 1.0:
            raise InvalidActionError(
                f"The gripper action is {values[0]}; it must lie between 0 (closed) and 1 (open).", "gripper out of range"
            )
        return values

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
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


@dataclass
class FingerMove:
    """The finger motion of the present tick, from `pre_step` to `post_step`."""

    target: float | None = None
    """Commanded position of the fingers [m]."""
    opens: bool = False
    """Whether that is farther open than they were."""


class GripperJointPosition(GripperMode):
    """One number: the position of both fingers [m], or its change, for one tick; then the fingers hold.

    Positions beyond the range of a finger mean its end.

    Args:
        attach_grasped_objects: Fix graspable bodies between the fingers once they can close no further.
        detach_before_open: Release before the fingers open; otherwise after.
        absolute_mode: A position; otherwise a difference to the measured one.
    """

    ticks = 1

    def __init__(
        self, attach_grasped_objects: bool | None = None, detach_before_open: bool = True, absolute_mode: bool = True
    ) -> None:
        super().__init__(attach_grasped_objects, detach_before_open)
        self.absolute_mode = as_flag(absolute_mode, "absolute_mode")

    def shape(self, runtime: Runtime) -> tuple[int]:
        """One number."""
        return (1,)

    def spec(self, runtime: Runtime) -> ActionSpec:
        """From 0, shut, to the range of a finger; differences span it both ways."""
        high = np.array([runtime.description.gripper_open])
        return ActionSpec(("finger",), ("m",), np.zeros(1) if self.absolute_mode else -high, high, "joint", 1)

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Command the finger motors, without stepping; opening lets go."""
        here, reach = runtime.robot.fingers, runtime.description.gripper_open
        target = float(np.clip(values[0] if self.absolute_mode else here.mean() + values[0], 0.0, reach))
        opens = bool(target > here.mean() + 1e-4)
        if opens and self.detach_before_open:
            runtime.gripper.release()
        if not runtime.gripper.grasped or opens:
            runtime.gripper.set_target(target / reach, runtime.description.finger_speed)
        move = runtime.kept(self, FingerMove)
        move.target, move.opens = target, opens

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """One tick, in which the arm holds still."""
        if runtime.robot.mode == "torque":
            runtime.hold()
        runtime.step()

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Attach what stopped the fingers, or let go; then hold.

        Raises:
            InvalidActionError: No `pre_step` came before.
        """
        move = runtime.kept(self, FingerMove)
        target, move.target = move.target, None
        if target is None:
            raise InvalidActionError("`post_step` of the fingers was called without `pre_step`. Call that first.")
        stalled = runtime.robot.fingers.mean() > target + 1e-3 and not runtime.gripper.moving
        hold_or_release(runtime, release=move.opens, attach=self.attaches(runtime) and stalled)
        runtime.gripper.hold()
