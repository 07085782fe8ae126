"""Values are checked here, once, where they enter: numbers, whole numbers, switches, arrays, poses, seeds, sizes, settings.

Every check returns the value as the package uses it, or raises `InvalidValue` (or the subclass that it is given), which names
what was given, its value, and what would do. Nothing is turned into a number that is none: no text, no truth value, no date.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rlbench_pin.front_door import front_door
from rlbench_pin.values.arrays import SMALLEST_NORM, as_array, as_finite, as_pose, as_rows, as_vector
from rlbench_pin.values.settings import (
    FINITE,
    FLAG,
    LARGEST_COUNT,
    NOT_NEGATIVE,
    POSITIVE,
    Rule,
    Settings,
    check_settings,
    counted,
    one_of,
    record_of,
    ruled,
)
from rlbench_pin.values.single import (
    LARGEST_SEED,
    LARGEST_SIDE,
    as_choice,
    as_flag,
    as_function,
    as_interval,
    as_names,
    as_number,
    as_path,
    as_picture_size,
    as_record,
    as_seed,
    as_several,
    as_text,
    as_whole,
    is_whole,
    items_of,
)

__all__ = [
    "FINITE",
    "FLAG",
    "LARGEST_COUNT",
    "LARGEST_SEED",
    "LARGEST_SIDE",
    "NOT_NEGATIVE",
    "POSITIVE",
    "SMALLEST_NORM",
    "Rule",
    "Settings",
    "as_array",
    "as_choice",
    "as_finite",
    "as_flag",
    "as_function",
    "as_interval",
    "as_names",
    "as_number",
    "as_path",
    "as_picture_size",
    "as_pose",
    "as_record",
    "as_rows",
    "as_seed",
    "as_several",
    "as_text",
    "as_vector",
    "as_whole",
    "check_settings",
    "counted",
    "is_whole",
    "items_of",
    "one_of",
    "record_of",
    "ruled",
]

if not TYPE_CHECKING:
    __getattr__, __dir__ = front_door(__name__)
