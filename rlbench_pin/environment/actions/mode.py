"""Action modes: the meaning of actions, the base classes of modes, and an arm and a gripper mode combined."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

import numpy as np

from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError, InvalidValue, shown
from rlbench_pin.spatial import FloatArray, compose
from rlbench_pin.values import as_array, as_vector

POSE_NAMES = ("x", "y", "z", "qx", "qy", "qz", "qw")
POSE_UNITS = ("m", "m", "m", "1", "1", "1", "1")
TWIST_NAMES = ("vx", "vy", "vz", "wx", "wy", "wz")
TWIST_UNITS = ("m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s")


@dataclass(frozen=True, eq=False)
class ActionSpec:
    """The numbers of one action, in order."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    low: FloatArray
    """Lowest values, shape (n,), read-only."""
    high: FloatArray
    """Highest values, shape (n,), read-only."""
    frame: str
    """Axes that Cartesian numbers are expressed in, or `joint`."""
    ticks: int | None
    """Control ticks that one action takes; None when that depends on the motion."""

    def __post_init__(self) -> None:
        if not len(self.names) == len(self.units) == len(self.low) == len(self.high):
            raise ValueError(
                f"{len(self.names)} names, {len(self.units)} units and {len(self.low)} bounds do not belong together"
            )
        for name in ("low", "high"):
            bound = np.array(getattr(self, name), dtype=float)
            bound.setflags(write=False)
            object.__setattr__(self, name, bound)

    @property
    def size(self) -> int:
        """How many numbers an action has."""
        return len(self.names)

    def joined(self, other: ActionSpec) -> ActionSpec:
        """Return the description of this action followed by another."""
        ticks = None if self.ticks is None or other.ticks is None else self.ticks + other.ticks
        return ActionSpec(
            (*self.names, *other.names),
            (*self.units, *other.units),
            np.concatenate([self.low, other.low]),
            np.concatenate([self.high, other.high]),
            self.frame,
            ticks,
        )


class Mode:
    """Base class of all modes: what the numbers of an action mean (`spec`), and what they do.

    `action` checks one action and runs `pre_step`, `steps` and `post_step`. A mode whose action takes one control tick overrides
    `pre_step` and `post_step`, and sets `ticks` to 1. Then other modes can share the tick: all pre-steps, one `runtime.step()`,
    all post-steps. A mode that takes as many ticks as its motion needs overrides `steps`.

    A mode contains settings only, which may be replaced at any time: one object may serve several environments. Data of one
    environment belongs into `runtime.kept`.

    Attributes:
        ticks: Control ticks that one action takes; None when that depends on the motion.
    """

    ticks: int | None = None

    @property
    def optional_values(self) -> int:
        """How many numbers may follow those of the specification, all or none."""
        return 0

    def spec(self, runtime: Runtime) -> ActionSpec:
        """Return names, units, bounds and frame of the numbers."""
        raise NotImplementedError(f"{type(self).__name__} needs a method `spec(runtime)` where its bounds are asked for.")

    def shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action, without optional values."""
        return (self.spec(runtime).size,)

    def bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action, each of shape (n,)."""
        spec = self.spec(runtime)
        return spec.low.copy(), spec.high.copy()

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return finite `values` (n,), or others to take their place, or raise InvalidActionError to refuse them."""
        return values

    def pre_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Do what comes before the tick of an action (n,), such as commanding the motors, without stepping. Here nothing."""

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Run the ticks of an action (n,). Here one."""
        runtime.step()

    def post_step(self, runtime: Runtime, values: FloatArray) -> None:
        """Do what comes after the tick of an action (n,), such as holding still, without stepping. Here nothing."""

    def run(self, runtime: Runtime, values: FloatArray) -> None:
        """Run one action (n,) that is checked, to its end."""
        self.pre_step(runtime, values)
        self.steps(runtime, values)
        self.post_step(runtime, values)

    def action(self, runtime: Runtime, action: object) -> None:
        """Check one action, then run it to its end, or until the episode is over.

        Raises:
            InvalidActionError: The action is refused; nothing has moved.
        """
        values = as_action(action, self.shape(runtime)[0], type(self).__name__, self.optional_values)
        self.run(runtime, self.check(runtime, values))


class ArmActionMode(Mode):
    """Turns numbers into arm motion."""


class GripperActionMode(Mode):
    """Turns numbers into finger motion."""


class ActionMode(Mode):
    """An arm mode and a gripper mode; subclasses say how they share one action, by `steps` or by `pre_step` and `post_step`.

    Numbers that the arm mode takes beyond its specification come last in the action.

    Args:
        arm_action_mode: Mode of the first numbers.
        gripper_action_mode: Mode of the numbers after them.
    """

    def __init__(self, arm_action_mode: ArmActionMode, gripper_action_mode: GripperActionMode) -> None:
        self.arm_action_mode, self.gripper_action_mode = arm_action_mode, gripper_action_mode

    @property
    def optional_values(self) -> int:
        """Those of the arm mode."""
        return self.arm_action_mode.optional_values

    def spec(self, runtime: Runtime) -> ActionSpec:
        """The numbers of the arm, then those of the gripper."""
        return self.arm_action_mode.spec(runtime).joined(self.gripper_action_mode.spec(runtime))

    def shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action, without optional values."""
        return (self.arm_action_mode.shape(runtime)[0] + self.gripper_action_mode.shape(runtime)[0],)

    def check(self, runtime: Runtime, values: FloatArray) -> FloatArray:
        """Return the numbers as both modes want them, or raise InvalidActionError when one of them refuses its numbers."""
        arm, gripper = self.split(runtime, values)
        arm, gripper = self.arm_action_mode.check(runtime, arm), self.gripper_action_mode.check(runtime, gripper)
        size = self.arm_action_mode.shape(runtime)[0]
        return np.concatenate([arm[:size], gripper, arm[size:]])

    def split(self, runtime: Runtime, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the numbers of the arm, optional ones last, and those of the gripper."""
        arm = self.arm_action_mode.shape(runtime)[0]
        both = arm + self.gripper_action_mode.shape(runtime)[0]
        return np.concatenate([values[:arm], values[both:]]), values[arm:both]


class MoveArmThenGripper(ActionMode):
    """The arm action runs to its end, then the gripper action. What ends the episode ends the action.

    With `EndEffectorPoseViaPlanning` a ninth number may follow the gripper's: 1 plans without collision checks, 0 with them.
    """

    def steps(self, runtime: Runtime, values: FloatArray) -> None:
        """Move the arm, then the gripper."""
        arm, gripper = self.split(runtime, values)
        self.arm_action_mode.run(runtime, arm)
        if not runtime.over:
            self.gripper_action_mode.run(runtime, gripper)


def as_action(action: object, size: int, what: str, more: int = 0) -> FloatArray:
    """Return `action` as a finite float64 vector of `size` numbers, or with `more` after them, or raise InvalidActionError."""
    try:
        array = as_array(action, what)
    except InvalidValue as error:
        raise InvalidActionError(f"{what} takes {size} numbers, not {shown(action)}. It {error.problem}.") from error
    if array.shape not in ((size,), (size + more,)):
        shapes = f"({size},)" if more == 0 else f"({size},) or ({size + more},)"
        raise InvalidActionError(f"{what} takes an array of shape {shapes}, not {array.shape}.", "wrong shape")
    if not all(map(math.isfinite, array.tolist())):
        bad = ", ".join(str(i) for i in np.flatnonzero(~np.isfinite(array)))
        raise InvalidActionError(f"{what} got NaN or infinity at index {bad}. Check the policy's output.", "not finite")
    return array.copy()


# Frames --------------------------------------------------------------------------------------------------------------


class RelativeFrame(IntEnum):
    """Frame that a Cartesian action is expressed in."""

    WORLD = 0
    EE = 1


FrameChoice = RelativeFrame | Literal["world", "end effector"]
_FRAME_WORDS = {"world": RelativeFrame.WORLD, "end effector": RelativeFrame.EE}


def as_frame(frame: FrameChoice | int | str) -> RelativeFrame:
    """Accept the enum or its words."""
    if isinstance(frame, str):
        if frame not in _FRAME_WORDS:
            raise InvalidActionError(f"No relative frame is called '{frame}'. Use 'world' or 'end effector'.")
        return _FRAME_WORDS[frame]
    try:
        return RelativeFrame(frame)
    except (ValueError, TypeError, RuntimeError) as error:  # what cannot be compared
        raise InvalidActionError(f"No relative frame is {shown(frame)}. Use 'world' or 'end effector'.") from error


def assert_unit_quaternion(quaternion: FloatArray) -> None:
    """Raise InvalidActionError when a quaternion (4,) is not of length 1."""
    norm = float(np.linalg.norm(quaternion))
    if not np.isclose(norm, 1.0):
        raise InvalidActionError(
            f"The quaternion {np.round(quaternion, 4).tolist()} has norm {norm:.4f}. "
            "Divide it by its norm; the order is x, y, z, w.",
            "not a rotation",
        )


def calculate_delta_pose(current: FloatArray, action: FloatArray, frame: RelativeFrame = RelativeFrame.WORLD) -> FloatArray:
    """Apply a delta pose (7,) to the current tip pose (7,).

    In the world frame the position is added along world axes and the rotation multiplied from the left; in the end-effector
    frame the whole delta is composed on the right.
    """
    current, action = as_vector(current, 7, "current"), as_vector(action, 7, "action")
    if frame is RelativeFrame.EE:
        return compose(current, action)
    rotation = compose(np.concatenate([np.zeros(3), action[3:]]), np.concatenate([np.zeros(3), current[3:]]))
    return np.concatenate([current[:3] + action[:3], rotation[3:]])
