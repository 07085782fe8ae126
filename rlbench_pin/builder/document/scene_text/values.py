"""How values are written in a scene file: rounded to what a reviewer can read, in the order and style of the library."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import tomlkit

from rlbench_pin.values import as_number

LENGTH_DIGITS, OTHER_DIGITS = 4, 6
"""Lengths and colours are rounded to 1e-4, other numbers to 1e-6."""
_FINE = 1e-3
"""Sizes below this keep two digits that count [m]."""
_EXACT_DIGITS = 7
_NICE_ANGLE, _NEAR_NICE = math.pi / 12.0, 1e-4
"""Angles as near to a multiple of 15 degrees are written as that [rad]."""
_LENGTHS = frozenset({"pose", "points", "size", "footprint", "footprint_center", "color"})
_LONGEST_LINE = 120
KEYS = (
    "name", "asset", "parent", "pose", "rpy", "poses", "static", "yaw", "footprint", "footprint_center", "shape", "size",
    "fixed", "collides", "color", "scale", "position", "friction", "damping", "spring", "locked", "path", "points", "arc",
    "ignore_collisions", "gripper", "symmetry",
)  # fmt: skip
"""The order in which keys are written."""


def place_of(key: str) -> int:
    """Return the place of a key among others; unknown ones come last."""
    return KEYS.index(key) if key in KEYS else len(KEYS)


def rounded_length(value: float) -> float:
    """Round a coordinate to 1e-4 m."""
    return round(float(value), LENGTH_DIGITS) + 0.0


def rounded_angle(value: float) -> float:
    """Round an angle to 1e-4 rad; right angles and the like to 1e-7."""
    nice = round(value / _NICE_ANGLE) * _NICE_ANGLE
    exact = abs(value - nice) < _NEAR_NICE
    return round(float(nice), _EXACT_DIGITS) + 0.0 if exact else round(float(value), LENGTH_DIGITS) + 0.0


def rounded(key: str, value: float) -> float:
    """Round a number that is said of a key."""
    if key in ("yaw", "rpy", "angle"):
        return rounded_angle(value)
    if key not in _LENGTHS:
        return round(float(value), OTHER_DIGITS) + 0.0
    if key == "size" and 0.0 < abs(value) < _FINE:
        return float(f"{value:.2g}")
    return rounded_length(value)


def plain(key: str, value: object) -> object:
    """Turn a value into what TOML has: lists, rounded numbers, tables without keys that say nothing."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, bool | str | int):
        return value
    if isinstance(value, float):
        return rounded(key, as_number(value, key))
    if isinstance(value, Mapping):
        return {inner: plain(inner, item) for inner, item in value.items() if item is not None}
    if isinstance(value, Sequence):
        return [plain(key, item) for item in value]
    return value


def literal(value: object, column: int = 0) -> str:
    """Return a plain value as TOML.

    Args:
        value: Texts, numbers, truth values, lists and tables of them.
        column: Where it begins in its line; lists of lists that would be too long are written on several lines.
    """
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {literal(item)}' for key, item in value.items())} }}"
    if not isinstance(value, list):
        return tomlkit.item(value).as_string()
    parts = [literal(part) for part in value]
    line = f"[{', '.join(parts)}]"
    if column + len(line) <= _LONGEST_LINE or not any(isinstance(part, list) for part in value):
        return line
    return f"[\n{_filled(parts)}]"


def _filled(parts: list[str]) -> str:
    """Lay elements out on lines that are not too long."""
    lines, line = "", "   "
    for part in parts:
        if len(line) + len(part) + 2 > _LONGEST_LINE and line.strip():
            lines, line = f"{lines}{line}\n", "   "
        line += f" {part},"
    return f"{lines}{line}\n"


def is_same(a: object, b: object, near: float = 5e-7) -> bool:
    """Whether two values say the same; numbers to `near`."""
    if isinstance(a, bool | str) or isinstance(b, bool | str) or a is None or b is None:
        return type(a) is type(b) and bool(a == b)
    if isinstance(a, int | float) and isinstance(b, int | float):
        return abs(a - b) < near
    if isinstance(a, Sequence) and isinstance(b, Sequence):
        return len(a) == len(b) and all(is_same(x, y, near) for x, y in zip(a, b, strict=True))
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(is_same(a[key], b[key], near) for key in a)
    return bool(a == b)
