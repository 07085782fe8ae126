"""Poses as a scene file says them: `[x, y, z]`, perhaps with a yaw, or with `rpy`; what did not change stays as it is written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rlbench_pin.builder.document.scene_text.values import is_same, rounded_angle, rounded_length
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.scene import FrameSpec
from rlbench_pin.scene.reader import ShortFormError, write_out
from rlbench_pin.spatial import FloatArray, euler_to_quaternion, pose_to_matrix

Numbers = list[float]
_SAME_TURN, _EXACT_TURN = 2e-6, 1e-10
_LOCKED = 1e-6
"""Cosine of the pitch below which roll and yaw turn about the same axis."""
_NO_TURN = 1e-5
"""Angles up to this are none [rad]."""
_QUATERNION_DIGITS = 7


def pose_keys(new: Any, entry: Mapping[str, Any], *, has_rpy: bool) -> dict[str, Numbers | None]:
    """Return what to write, or to take away (None), so that an entry says a new pose; nothing when it says it already.

    Args:
        new: `[x, y, z]`, with a yaw or a quaternion behind it.
        entry: What stands in the file.
        has_rpy: Whether the file may say `rpy` there.
    """
    goal, before = np.array(FrameSpec(name="place", pose=new).pose), _full(entry)
    written = entry.get("pose", [0.0, 0.0, 0.0])
    position = _position(goal, before, written)
    pose, rpy = [*position, *written[3:]], entry.get("rpy")
    if before is None or not _same_turn(goal, before):
        pose, rpy = _turned(position, goal, rpy, has_rpy)
    left_out = has_rpy and pose == [0.0, 0.0, 0.0] and not is_same(entry.get("pose"), pose)
    wanted: dict[str, Numbers | None] = {"pose": None if left_out else pose, "rpy": rpy}
    return {key: value for key, value in wanted.items() if not is_same(value, entry.get(key), 1e-12)}


def exact_pose_keys(new: Any, *, has_rpy: bool) -> dict[str, Numbers | None]:
    """Return `pose` and `rpy` that say a pose to 1e-9, each number with as few digits as that takes.

    Args:
        new: `[x, y, z]`, with a yaw or a quaternion behind it.
        has_rpy: Whether the file may say `rpy` there.
    """
    goal = np.array(FrameSpec(name="place", pose=new).pose)
    position = [_shortest(value) for value in goal[:3]]
    angles = [_shortest(angle) for angle in roll_pitch_yaw(goal.tolist())]
    short: dict[str, Numbers | None] = {"pose": position if any(position) else None, "rpy": angles}
    if not any(angles[:2]):
        short = {"pose": [*position, *angles[2:]], "rpy": None} if angles[2] else {**short, "rpy": None}
    said = _full({key: value for key, value in short.items() if value is not None})
    if said is not None and _same_turn(said, goal, _EXACT_TURN) and (has_rpy or short["rpy"] is None):
        return short
    return {"pose": [*position, *(_shortest(value) for value in goal[3:])], "rpy": None}


def _shortest(value: float) -> float:
    """Round to the fewest digits that keep a number to 1e-11."""
    return next((r for digits in range(12) if abs((r := round(float(value), digits)) - value) < 1e-11), float(value)) + 0.0


def short_pose(new: Any, written: Sequence[float] | None = None) -> Numbers:
    """Return a pose as one list of numbers, such as an element of `poses`.

    Args:
        new: `[x, y, z]`, with a yaw or a quaternion behind it.
        written: What stands there now.
    """
    entry = {} if written is None else {"pose": list(written)}
    found = pose_keys(new, entry, has_rpy=False)
    return found.get("pose") or list(written or [0.0, 0.0, 0.0])


def roll_pitch_yaw(pose: Sequence[float], near: Sequence[float] | None = None) -> tuple[float, float, float]:
    """Return the turns about the fixed x, y and z axes that make the rotation of a pose (7,) [rad].

    Args:
        pose: The pose.
        near: Angles to which the answer should be close, of the two that there are; None for the smallest. More zeros come first.
    """
    turn = pose_to_matrix(pose)[:3, :3]
    cosine = math.hypot(float(turn[0, 0]), float(turn[1, 0]))
    pitch = math.atan2(-turn[2, 0], cosine)
    if cosine < _LOCKED:
        return math.atan2(-turn[1, 2], turn[1, 1]), pitch, 0.0
    roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    other = (_wrapped(roll + math.pi), _wrapped(math.pi - pitch), _wrapped(yaw + math.pi))
    target = (0.0, 0.0, 0.0) if near is None else tuple(near)

    def effort(angles: Sequence[float]) -> tuple[int, float]:
        distance = sum(abs(_wrapped(a - b)) for a, b in zip(angles, target, strict=True))
        return sum(abs(angle) > _NO_TURN for angle in angles), round(distance, 6)

    return min(((roll, pitch, yaw), other), key=effort)


def _turned(position: Numbers, goal: FloatArray, rpy: Sequence[float] | None, has_rpy: bool) -> tuple[Numbers, Numbers | None]:
    """Write a rotation in the shortest way."""
    near = rpy if rpy is not None and len(rpy) == 3 else None
    angles = [rounded_angle(angle) for angle in roll_pitch_yaw(goal.tolist(), near)]
    if not any(angles[:2]):
        return [*position, *angles[2:]] if angles[2] else position, None
    if has_rpy:
        return position, angles
    quaternion = [round(float(v), _QUATERNION_DIGITS) + 0.0 for v in euler_to_quaternion(*angles)]
    return [*position, *quaternion], None


def _position(goal: FloatArray, before: FloatArray | None, written: Sequence[float]) -> Numbers:
    """Round what has changed, and leave the rest as it is written."""
    kept = [False] * 3 if before is None else [is_same(float(a), float(b)) for a, b in zip(goal[:3], before[:3], strict=True)]
    return [written[i] if kept[i] else rounded_length(goal[i]) for i in range(3)]


def _same_turn(a: FloatArray, b: FloatArray, near: float = _SAME_TURN) -> bool:
    return bool(min(np.abs(a[3:] - b[3:]).max(), np.abs(a[3:] + b[3:]).max()) < near)


def _full(entry: Mapping[str, Any]) -> FloatArray | None:
    """Return the pose (7,) that an entry says, None when what it says is none."""
    said = {key: entry[key] for key in ("pose", "rpy") if key in entry}
    try:
        return np.array(FrameSpec(name="place", **write_out("frame", said)[0]).pose)
    except (RlbenchPinError, ShortFormError):
        return None


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)
