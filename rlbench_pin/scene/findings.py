"""What pydantic finds wrong with a record, in our words: where it is, what it is, and what would do."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

from pydantic import ValidationError

from rlbench_pin.errors import nearest_name, shown

_WORDS = {
    "Input should be a valid tuple": "it has to be a list",
    "Input should be a valid string": "it has to be a text",
    "Input should be a valid boolean": "it has to be true or false",
    "Input should be a valid dictionary": "it has to be a table",
    "Input should be": "it has to be",
    "String should match pattern '^[a-z][a-z0-9_]*$'": "it has to be small letters, digits and `_`, a letter first",
    "String should have": "it has to have",
    "Tuple should have": "it has to have",
}
"""How messages of pydantic begin -> our words for it."""
_KINDS = ("float", "int", "str", "literal", "bool")


@dataclass(frozen=True)
class Finding:
    """The first thing that is wrong with a record."""

    kind: Literal["unknown", "missing", "wrong"]
    """A key that there is not, a key that is not there, or a value that cannot be used."""
    location: tuple[int | str, ...]
    """Keys and numbers that lead to it."""
    value: object
    """What was given."""
    problem: str
    """What is wrong, as a sentence."""


def first_finding(error: ValidationError) -> Finding:
    """Return the first finding of a validation; a misspelt key explains a missing one, so it comes first."""
    findings = error.errors(include_url=False)
    first = next((f for f in findings if f["type"] == "extra_forbidden"), findings[0])
    *way, last = first["loc"] or ("",)
    location = (*(part for part in way if not _is_kind(part)), last)
    given = first["input"]
    if first["type"] == "extra_forbidden":
        return Finding("unknown", location, given, f"'{location[-1]}' is not known here.")
    if first["type"] == "missing":
        if isinstance(last, int):
            return Finding("wrong", location[:-1], given, f"it has to have more than {last} items.")
        return Finding("missing", location, given, f"the key '{last}' is missing.")
    location = tuple(part for part in first["loc"] if not _is_kind(part))
    value = "" if isinstance(given, dict) else f" (given: {shown(given)})"
    return Finding("wrong", location, given, f"{_in_our_words(first['msg'])}{value}.")


def _in_our_words(message: str) -> str:
    for theirs, ours in _WORDS.items():
        if message.startswith(theirs):
            return ours + message.removeprefix(theirs).replace(" after validation", "")
    return message.removeprefix("Value error, ")


def _is_kind(part: int | str) -> bool:
    """Whether a part of a location is one of the kinds that a value may be of, which pydantic names there."""
    return part in _KINDS or (isinstance(part, str) and "[" in part)


def key_hint(key: str, known: Collection[str]) -> str:
    """Say which key may have been meant by an unknown one, or which there are."""
    names = sorted(known)
    near = nearest_name(key, names)
    return f"Did you mean '{near}'?" if near else f"Known keys: {', '.join(names)}."


def dotted(parts: tuple[int | str, ...]) -> str:
    """Write a location as one text, such as `arc.axis.0`."""
    return ".".join(str(part) for part in parts)
