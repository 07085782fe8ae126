"""Values of scene files: rounded to what a reviewer can read, in the order and style of the library, poses in short forms."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import tomlkit

from rlbench_pin.errors import InvalidValue, RlbenchPinError, UnknownName
from rlbench_pin.scene import FrameSpec
from rlbench_pin.scene.reader import ShortFormError, TablePlacement, write_out
from rlbench_pin.scene.spec import ArcSpec, PlacementSpec, Spec, SpringSpec
from rlbench_pin.scene.writer import TABLES
from rlbench_pin.spatial import FloatArray, euler_to_quaternion, pose_to_matrix
from rlbench_pin.values import as_number, as_several

Numbers = list[float]
KEYS = (
    "name", "asset", "parent", "pose", "rpy", "poses", "static", "yaw", "footprint", "footprint_center", "shape", "size",
    "fixed", "collides", "color", "scale", "position", "friction", "damping", "spring", "locked", "path", "points", "arc",
    "ignore_collisions", "compliant", "gripper", "symmetry",
)  # fmt: skip
"""The order in which keys are written."""
_FOUR_DIGITS = frozenset({"pose", "points", "size", "footprint", "footprint_center", "color", "scale", "gripper", "position"})
_LENGTH_DIGITS, _OTHER_DIGITS, _EXACT_DIGITS = 4, 6, 7
"""Lengths and colours are rounded to 1e-4, other numbers to 1e-6, right angles and quaternions to 1e-7."""
_FINE = 1e-3
"""Sizes below this keep two significant digits [m]."""
_NICE_ANGLE, _NEAR_NICE = math.pi / 12.0, 1e-4
"""Angles as near to a multiple of 15 degrees are written as that [rad]."""
_MAX_LINE_LENGTH = 120
_SAME_ROTATION, _EXACT_ROTATION = 2e-6, 1e-10
"""Quaternions whose components differ by less are the same rotation."""
_LOCKED = 1e-6
"""Cosine of the pitch below which roll and yaw rotate about the same axis."""
_ZERO_ANGLE = 1e-5
"""Angles up to this count as zero [rad]."""
_PARTS: Mapping[str, type[Spec]] = {"arc": ArcSpec, "spring": SpringSpec}


# Numbers and literals ---------------------------------------------------------------------------------------------------------


def place_of(key: str) -> int:
    """Return the place of a key among others; unknown ones come last."""
    return KEYS.index(key) if key in KEYS else len(KEYS)


def _rounded_length(value: float) -> float:
    return round(float(value), _LENGTH_DIGITS) + 0.0


def _rounded_angle(value: float) -> float:
    nice = round(value / _NICE_ANGLE) * _NICE_ANGLE
    return round(float(nice), _EXACT_DIGITS) + 0.0 if abs(value - nice) < _NEAR_NICE else _rounded_length(value)


def _rounded(key: str, value: float) -> float:
    if key in ("yaw", "rpy", "angle"):
        return _rounded_angle(value)
    if key not in _FOUR_DIGITS:
        return round(float(value), _OTHER_DIGITS) + 0.0
    if key == "size" and 0.0 < abs(value) < _FINE:
        return float(f"{value:.2g}")
    return _rounded_length(value)


def _plain(key: str, value: object) -> object:
    """Convert a value to what TOML has: lists, rounded numbers, tables without keys that are None."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, str) and not value.isprintable() and value.encode(errors="replace").decode() != value:
        raise InvalidValue(key, value, "has to be text that can be written in UTF-8")
    if isinstance(value, bool | str) or (key == "symmetry" and isinstance(value, int)):
        return value
    if isinstance(value, int | float):
        return _rounded(key, as_number(value, key))
    if isinstance(value, Mapping):
        return {inner: _plain(inner, item) for inner, item in value.items() if item is not None}
    if isinstance(value, Sequence):
        return [_plain(key, item) for item in value]
    raise InvalidValue(key, value, "has to be a text, a number, true or false, or a list or a table of such")


def literal(value: object, column: int = 0) -> str:
    """Return a plain value as TOML that begins in a column; long lists of lists are written on several lines."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {literal(item)}' for key, item in value.items())} }}"
    if not isinstance(value, list):
        return tomlkit.item(value).as_string()
    parts = [literal(part) for part in value]
    text = f"[{', '.join(parts)}]"
    if column + len(text) <= _MAX_LINE_LENGTH or not any(isinstance(part, list) for part in value):
        return text
    lines, line = "", "   "
    for part in parts:
        if len(line) + len(part) + 2 > _MAX_LINE_LENGTH and line.strip():
            lines, line = f"{lines}{line}\n", "   "
        line += f" {part},"
    return f"[\n{lines}{line}\n]"


def is_same(a: object, b: object, near: float = 5e-7) -> bool:
    """Whether two values are equal, numbers to `near`."""
    if isinstance(a, bool | str) or isinstance(b, bool | str) or a is None or b is None:
        return type(a) is type(b) and bool(a == b)
    if isinstance(a, int | float) and isinstance(b, int | float):
        return abs(a - b) < near
    if isinstance(a, Sequence) and isinstance(b, Sequence):
        return len(a) == len(b) and all(is_same(x, y, near) for x, y in zip(a, b, strict=True))
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(is_same(a[key], b[key], near) for key in a)
    return bool(a == b)


# Records ----------------------------------------------------------------------------------------------------------------------


def written_keys(table: str, values: Mapping[str, Any], raw: Mapping[str, Any], *, short_forms: bool = True) -> dict[str, Any]:
    """Return the keys to write so that an entry has other values.

    Args:
        table: `body`, ..., or `placement`.
        values: Key of the record -> value; None is its default.
        raw: The keys of the entry as they are in the file.
        short_forms: Whether the format of the file has `rpy`, and heights of the placement from the table top.

    Returns:
        Key of the file -> plain value, None to remove it; empty when the file has all values already.

    Raises:
        UnknownName: The record has no such key.
        InvalidRecord: A pose or a part is invalid.
    """
    placement = TablePlacement if short_forms else PlacementSpec
    record: type[Spec] = placement if table == "placement" else TABLES[table]
    try:
        before = record(**write_out(table, dict(raw))[0])
    except (RlbenchPinError, ShortFormError, TypeError):
        before = None
    found: dict[str, Any] = {}
    for key, value in values.items():
        if key not in record.model_fields:
            raise UnknownName(f"key of [[{table}]]", key, tuple(record.model_fields))
        default = record.model_fields[key].get_default()
        if value is None:
            value = default
        elif key in _PARTS and isinstance(value, Mapping):
            value = _PARTS[key](**value)
        dumped = _dumped(value)
        if before is not None and (key in raw or key == "pose") and is_same(_dumped(getattr(before, key)), dumped):
            continue
        if key == "pose":
            found |= pose_keys(value, raw, has_rpy=short_forms and table != "placement")
        elif is_same(dumped, _dumped(default)):
            found |= {key: None} if key in raw else {}
        elif key == "points":
            old = raw.get("points", [])
            points = as_several(value, key)
            found[key] = [short_pose(pose, old[k] if k < len(old) else None) for k, pose in enumerate(points)]
        else:
            found[key] = _plain(key, dumped)
    return found


def _dumped(value: Any) -> Any:
    if isinstance(value, Spec):
        return value.model_dump(exclude_defaults=True)
    return value.tolist() if hasattr(value, "tolist") else value


# Poses ------------------------------------------------------------------------------------------------------------------------


def pose_keys(new: Any, entry: Mapping[str, Any], *, has_rpy: bool) -> dict[str, Numbers | None]:
    """Return the keys to write, or to remove (None), so that an entry has a new pose; empty when it has it already.

    Args:
        new: `[x, y, z]`, with a yaw or a quaternion behind it.
        entry: The keys in the file; numbers that do not change keep their digits.
        has_rpy: Whether the file may have `rpy` there.
    """
    goal, before = _full_pose(new), _pose_of(entry)
    written = entry.get("pose", [0.0, 0.0, 0.0])
    kept = [before is not None and is_same(float(goal[i]), float(before[i])) for i in range(3)]
    position = [written[i] if kept[i] else _rounded_length(goal[i]) for i in range(3)]
    pose, rpy = [*position, *written[3:]], entry.get("rpy")
    if before is None or not _same_rotation(goal, before, _SAME_ROTATION):
        near = rpy if rpy is not None and len(rpy) == 3 else None
        angles = [_rounded_angle(angle) for angle in roll_pitch_yaw(goal, near)]
        pose, rpy = position, None
        if any(angles[:2]) and has_rpy:
            rpy = angles
        elif any(angles[:2]):
            pose = [*position, *(round(float(v), _EXACT_DIGITS) + 0.0 for v in euler_to_quaternion(*angles))]
        elif angles[2]:
            pose = [*position, angles[2]]
    left_out = has_rpy and pose == [0.0, 0.0, 0.0] and not is_same(entry.get("pose"), pose)
    wanted: dict[str, Numbers | None] = {"pose": None if left_out else pose, "rpy": rpy}
    return {key: value for key, value in wanted.items() if not is_same(value, entry.get(key), 1e-12)}


def exact_pose_keys(new: Any, *, has_rpy: bool) -> dict[str, Numbers | None]:
    """Return `pose` and `rpy` that express a pose to 1e-9, each number with as few digits as that takes."""
    goal = _full_pose(new)
    position = [_shortest(value) for value in goal[:3]]
    angles = [_shortest(angle) for angle in roll_pitch_yaw(goal)]
    short: dict[str, Numbers | None] = {"pose": position if any(position) else None, "rpy": angles}
    if not any(angles[:2]):
        short = {"pose": [*position, angles[2]], "rpy": None} if angles[2] else {**short, "rpy": None}
    said = _pose_of({key: value for key, value in short.items() if value is not None})
    if said is not None and _same_rotation(said, goal, _EXACT_ROTATION) and (has_rpy or short["rpy"] is None):
        return short
    return {"pose": [*position, *(_shortest(value) for value in goal[3:])], "rpy": None}


def short_pose(new: Any, written: Sequence[float] | None = None) -> Numbers:
    """Return a pose as one list of numbers, such as an item of `poses`, where `written` is now."""
    entry = {} if written is None else {"pose": list(written)}
    return pose_keys(new, entry, has_rpy=False).get("pose") or list(written or [0.0, 0.0, 0.0])


def roll_pitch_yaw(pose: Sequence[float] | FloatArray, near: Sequence[float] | None = None) -> tuple[float, float, float]:
    """Return the angles about the fixed x, y and z axes of the rotation of a pose (7,) [rad].

    Of the two solutions, return the one with more zeros, then the one closer to `near` (default: to zero).
    """
    rotation = pose_to_matrix(pose)[:3, :3]
    cosine = math.hypot(float(rotation[0, 0]), float(rotation[1, 0]))
    pitch = math.atan2(-rotation[2, 0], cosine)
    if cosine < _LOCKED:
        return math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0
    roll, yaw = math.atan2(rotation[2, 1], rotation[2, 2]), math.atan2(rotation[1, 0], rotation[0, 0])
    other = (_wrapped(roll + math.pi), _wrapped(math.pi - pitch), _wrapped(yaw + math.pi))
    target = (0.0, 0.0, 0.0) if near is None else tuple(near)

    def effort(angles: Sequence[float]) -> tuple[int, float]:
        distance = sum(abs(_wrapped(a - b)) for a, b in zip(angles, target, strict=True))
        return sum(abs(angle) > _ZERO_ANGLE for angle in angles), round(distance, 6)

    return min(((roll, pitch, yaw), other), key=effort)


def _full_pose(pose: Any) -> FloatArray:
    return np.array(FrameSpec(name="place", pose=pose).pose)


def _pose_of(entry: Mapping[str, Any]) -> FloatArray | None:
    """Return the pose (7,) of an entry, None when it is invalid."""
    written = {key: entry[key] for key in ("pose", "rpy") if key in entry}
    try:
        return np.array(FrameSpec(name="place", **write_out("frame", written)[0]).pose)
    except (RlbenchPinError, ShortFormError):
        return None


def _same_rotation(a: FloatArray, b: FloatArray, near: float) -> bool:
    return bool(min(np.abs(a[3:] - b[3:]).max(), np.abs(a[3:] + b[3:]).max()) < near)


def _shortest(value: float) -> float:
    """Round to the fewest digits that keep a number to 1e-11."""
    return next((r for digits in range(12) if abs((r := round(float(value), digits)) - value) < 1e-11), float(value)) + 0.0


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)
