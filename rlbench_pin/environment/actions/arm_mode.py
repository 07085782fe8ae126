"""What arm action modes share: frames, delta poses, and what a mode must offer."""

from __future__ import annotations

from enum import IntEnum
from typing import Literal, Protocol

import numpy as np

from rlbench_pin.environment.actions.mode import ActionPart
from rlbench_pin.errors import InvalidActionError, shown
from rlbench_pin.spatial import FloatArray, compose
from rlbench_pin.values import as_vector


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


class ArmActionMode(ActionPart, Protocol):
    """Turns numbers into arm motion."""
