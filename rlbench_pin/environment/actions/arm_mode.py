"""What all arm action modes share: frames, checks, delta poses, and what a mode must offer."""

from __future__ import annotations

from enum import IntEnum
from typing import Literal, Protocol

import numpy as np

from rlbench_pin.environment.actions.specification import ActionSpec
from rlbench_pin.environment.runtime import Runtime
from rlbench_pin.errors import InvalidActionError
from rlbench_pin.spatial import FloatArray, compose


class RelativeFrame(IntEnum):
    """Frame that a Cartesian action is expressed in."""

    WORLD = 0
    EE = 1


FrameChoice = RelativeFrame | Literal["world", "end effector"]
_FRAME_WORDS = {"world": RelativeFrame.WORLD, "end effector": RelativeFrame.EE}


def as_frame(frame: FrameChoice) -> RelativeFrame:
    """Accept the enum or its words."""
    if isinstance(frame, str):
        if frame not in _FRAME_WORDS:
            raise InvalidActionError(f"No relative frame is called '{frame}'. Use 'world' or 'end effector'.")
        return _FRAME_WORDS[frame]
    return RelativeFrame(frame)


def as_action(action: object, size: int, what: str) -> FloatArray:
    """Return `action` as a finite float64 vector of `size` numbers, or raise InvalidActionError."""
    try:
        array = np.array(action, dtype=float)
    except (TypeError, ValueError) as error:
        raise InvalidActionError(f"{what} takes {size} numbers, not {action!r}.") from error
    if array.shape != (size,):
        raise InvalidActionError(f"{what} takes an array of shape ({size},), not {array.shape}.")
    if not np.isfinite(array).all():
        bad = ", ".join(str(i) for i in np.flatnonzero(~np.isfinite(array)))
        raise InvalidActionError(f"{what} got NaN or infinity at index {bad}. Check the policy's output.")
    return array


def assert_unit_quaternion(quaternion: FloatArray) -> None:
    """Raise InvalidActionError when a quaternion (4,) is not of length 1."""
    norm = float(np.linalg.norm(quaternion))
    if not np.isclose(norm, 1.0):
        raise InvalidActionError(
            f"The quaternion {np.round(quaternion, 4).tolist()} has norm {norm:.4f}. "
            "Divide it by its norm; the order is x, y, z, w."
        )


def calculate_delta_pose(current: FloatArray, action: FloatArray, frame: RelativeFrame = RelativeFrame.WORLD) -> FloatArray:
    """Apply a delta pose (7,) to the current tip pose (7,).

    In the world frame the position is added along world axes and the rotation multiplied from the left; in the end-effector
    frame the whole delta is composed on the right.
    """
    if frame is RelativeFrame.EE:
        return compose(current, action)
    rotation = compose(np.concatenate([np.zeros(3), action[3:]]), np.concatenate([np.zeros(3), current[3:]]))
    return np.concatenate([current[:3] + action[:3], rotation[3:]])


class ArmActionMode(Protocol):
    """Turns numbers into arm motion."""

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


class SpecifiedMode:
    """Shape and bounds, read off the specification."""

    def action_spec(self, runtime: Runtime) -> ActionSpec:
        """Return what the numbers mean."""
        raise NotImplementedError

    def action_shape(self, runtime: Runtime) -> tuple[int]:
        """Return the shape of an action."""
        return (self.action_spec(runtime).size,)

    def action_bounds(self, runtime: Runtime) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest values of an action."""
        spec = self.action_spec(runtime)
        return spec.low.copy(), spec.high.copy()

    def check(self, runtime: Runtime, action: object) -> FloatArray:
        """Return `action` as a vector, or raise InvalidActionError."""
        return as_action(action, self.action_shape(runtime)[0], type(self).__name__)
