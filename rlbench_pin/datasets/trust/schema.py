"""Types and ranges of what JSON files say, and JSON itself without surprises."""

from __future__ import annotations

import json
from typing import Any, NoReturn

LARGEST = 2**64 - 1
"""The largest number that a dataset stores."""
_SHOWN = 60


def parse_json(text: str | bytes) -> Any:
    """Return what a JSON text says.

    Raises:
        ValueError: It is no JSON, is nested too deeply, or holds NaN or infinity.
    """
    try:
        return json.loads(text, parse_constant=_refuse)
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error


def is_whole(value: object, low: int = 0, high: int = LARGEST) -> bool:
    """Whether a value is a whole number in a range, both ends included; true and false are none."""
    return type(value) is int and low <= value <= high


def is_texts(value: object) -> bool:
    """Whether a value is a list of texts."""
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def is_text_map(value: object) -> bool:
    """Whether a value is a table of texts by name."""
    return isinstance(value, dict) and all(isinstance(item, str) for pair in value.items() for item in pair)


def short(value: object) -> str:
    """Return a value as a text that fits into a message."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # a number with thousands of digits; a list that is too deep
        text = f"a {type(value).__name__}"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"it holds {constant}, which is no number")
