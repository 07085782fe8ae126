"""The base class of all errors, and those that any part of the package may raise."""

from __future__ import annotations

import difflib
import pickle
from collections.abc import Collection, Mapping, Sequence
from typing import Any


class RlbenchPinError(Exception):
    """Base class of every error that this package raises on purpose.

    All of them can be pickled, with their text and their evidence, so that they travel between processes. Evidence that belongs
    to one process, such as a running task, arrives as a text that says what it was.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        """Say how the error is made again: without its `__init__`, whose arguments are not its text."""
        parts = super().__reduce__()
        evidence = parts[2] if len(parts) > 2 and isinstance(parts[2], dict) else {}
        return _made_again, (type(self), self.args), {name: _portable(value) for name, value in evidence.items()}


def _made_again(kind: type[RlbenchPinError], args: tuple[Any, ...]) -> RlbenchPinError:
    error = kind.__new__(kind, *args)
    error.args = args
    return error


def _portable(value: object) -> object:
    """Return the value where it can be pickled, the containers of it filled likewise, otherwise a text."""
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:  # whatever the classes of others raise
        if type(value) in (list, tuple):
            return type(value)(_portable(item) for item in value)  # type: ignore[call-arg, attr-defined]
        if isinstance(value, Mapping):
            return {str(key): _portable(item) for key, item in value.items()}
        return f"{type(value).__name__}: {value}"
    return value


def nearest_name(name: str, known: Collection[str]) -> str | None:
    """Return the known name most like `name`, or None when nothing is close."""
    near = difflib.get_close_matches(name, known, n=1)
    return near[0] if near else None


class UnknownName(RlbenchPinError):
    """A name is not in the catalogue it was looked up in."""

    def __init__(self, kind: str, name: str, known: Collection[str], command: str = "") -> None:
        if not isinstance(name, str):
            name = shown(name)
        self.kind, self.name, self.known = kind, name, tuple(known)
        near = nearest_name(name, self.known)
        guess = f" Did you mean '{near}'?" if near else ""
        where = f" `{command}` lists all {len(self.known)}." if command else f" Known: {_listing(self.known)}."
        super().__init__(f"No {kind} is called '{name}'.{guess}{where}")


def _listing(names: Sequence[str], limit: int = 12) -> str:
    shown = ", ".join(sorted(names)[:limit])
    more = len(names) - limit
    return f"{shown or 'none'}, and {more} more" if more > 0 else shown or "none"


class UnknownSetting(UnknownName, AttributeError):  # type: ignore[misc]  # both have a `name`
    """A record of settings has no attribute of that name."""

    def __init__(self, record: str, name: str, known: Collection[str]) -> None:
        self.record = record
        super().__init__(f"setting of {record}", name, known)
        self.name = name  # AttributeError forgets it

    def __reduce__(self) -> tuple[Any, ...]:
        """Say how the error is made again: `name` is kept by AttributeError, beside the other attributes."""
        return type(self), (self.record, self.name, self.known)


class InvalidValue(RlbenchPinError, ValueError):
    """A value cannot be used: a wrong kind, shape or size, NaN, outside its range.

    Args:
        what: What was given, as users call it.
        value: The value.
        problem: What it has to be, or what is wrong with it.
        hint: What to do.
    """

    def __init__(self, what: str, value: object, problem: str, hint: str = "") -> None:
        self.what, self.value, self.problem, self.hint = what, value, problem, hint
        super().__init__(f"{what} {problem}. Got {shown(value)}.{f' {hint}' if hint else ''}")


def shown(value: object, most: int = 120) -> str:
    """Return a value as text of about `most` letters on one line, whatever it is."""
    try:
        begins = _beginning(value, most)
        text = " ".join((str(begins) if isinstance(begins, _Words) else repr(begins)).split())
    except Exception:  # objects of users may refuse to be shown
        text = f"a {type(value).__name__}"
    return text if len(text) <= most else f"{text[:most]}..."


def _beginning(value: object, most: int) -> object:
    """Return as much of a long value as its text needs: the text of millions of numbers takes seconds."""
    if isinstance(value, str | bytes | list | tuple) and len(value) > most:
        return value[: most + 1]
    shape = getattr(value, "shape", ())
    if isinstance(shape, tuple) and len(shape) > 2 and hasattr(value, "ravel"):
        return _Words(f"an array of shape {shape}")
    return value


class _Words(str):
    """Words about a value that stand in its place."""


class MissingExtra(RlbenchPinError, ImportError):
    """An optional library is not installed; `extra` is the extra that brings it."""

    def __init__(self, what: str, library: str, extra: str) -> None:
        self.library, self.extra = library, extra
        super().__init__(f"{what} needs '{library}', which is not installed. {install_hint(extra)} brings it.")


def install_hint(extra: str) -> str:
    """Return what installs an extra. rlbench_pin is on no package index, so that its name alone would find nothing."""
    return f"`pip install -e '.[{extra}]'` in a clone of rlbench_pin"
