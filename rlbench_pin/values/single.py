"""Checks of single values: numbers, whole numbers, switches, words, seeds, intervals, sizes of pictures."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from os import PathLike, fsencode, fspath
from pathlib import Path
from typing import Any, TypeGuard, TypeVar

import numpy as np

from rlbench_pin.errors import InvalidValue, UnknownName

KindT = TypeVar("KindT")
LARGEST_SEED = 2**63 - 1
"""Stored episodes keep their seed in 64 bits, with a sign."""
LARGEST_SIDE = 8192
"""Pictures have at most so many columns and rows [px]."""
LONGEST_NAME, LONGEST_PATH = 255, 4095
"""Bytes of file names and paths of Linux."""
_NO_NUMBERS = (bool, np.bool_, np.timedelta64)
"""What numpy and Python count among their whole numbers, and we do not."""
_NUMBERS = (float, int, np.floating, np.integer)
_MADE_BY = {
    "Generator": "`np.random.default_rng(seed)` makes one.",
    "Demo": "`task.get_demos(1)` and `read_demo(path)` return some.",
}
"""Class -> what makes one, where users have to know."""


def as_number(
    value: object,
    what: str,
    error: type[InvalidValue] = InvalidValue,
    *,
    least: float = -math.inf,
    most: float = math.inf,
    above: float = -math.inf,
    finite: bool = True,
) -> float:
    """Return `value` as a float.

    Args:
        value: A number of Python or numpy; truth values and text are none.
        what: What it is called.
        error: What to raise.
        least: Smallest value allowed.
        most: Largest value allowed.
        above: Values have to be larger than this.
        finite: Whether infinity is refused. NaN always is.

    Raises:
        InvalidValue: It is no number, or outside the range.
    """
    good = isinstance(value, _NUMBERS) and not isinstance(value, _NO_NUMBERS)
    try:
        number = float(value) if good else math.nan  # type: ignore[arg-type]
    except OverflowError:
        number = math.nan
    if not (least <= number <= most and number > above) or (finite and math.isinf(number)):
        wanted = f"has to be a {'finite ' if finite else ''}number{_range_text(least, most, above)}"
        raise error(what, value, wanted)
    return number


def is_whole(value: object) -> TypeGuard[int | np.integer[Any]]:
    """Whether a value is a whole number of Python or numpy; True, 1.0, "1" and a stretch of time are none."""
    return isinstance(value, int | np.integer) and not isinstance(value, _NO_NUMBERS)


def as_whole(
    value: object, what: str, error: type[InvalidValue] = InvalidValue, *, least: int | None = None, most: int | None = None
) -> int:
    """Return `value` as an int of Python, which no addition wraps around.

    Args:
        value: A whole number of Python or numpy; 1.5, True and "1" are none.
        what: What it is called.
        error: What to raise.
        least: Smallest value allowed.
        most: Largest value allowed.

    Raises:
        InvalidValue: It is no whole number, or outside the range.
    """
    whole = is_whole(value)
    number = int(value) if is_whole(value) else 0
    if not whole or (least is not None and number < least) or (most is not None and number > most):
        low, high = -math.inf if least is None else least, math.inf if most is None else most
        raise error(what, value, f"has to be a whole number{_range_text(low, high)}")
    return number


def as_flag(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> bool:
    """Return a truth value of Python or numpy, or 0 or 1, as a bool; or raise InvalidValue."""
    if isinstance(value, np.timedelta64) or not isinstance(value, bool | np.bool_ | int | np.integer) or value not in (0, 1):
        raise error(what, value, "has to be True or False")
    return bool(value)


def as_choice(value: object, what: str, choices: Collection[str]) -> str:
    """Return one of some words.

    Raises:
        UnknownName: It is none of them; names the nearest.
    """
    if not isinstance(value, str) or value not in choices:
        raise UnknownName(what, value, tuple(choices))  # type: ignore[arg-type] # it shows whatever it is
    return value


def as_seed(value: object, what: str = "seed", error: type[InvalidValue] = InvalidValue) -> int:
    """Return a seed as an int, 0 <= seed < 2^63, the range that episode files hold; or raise InvalidValue."""
    return as_whole(value, what, error, least=0, most=LARGEST_SEED)


def as_interval(
    value: object, what: str, error: type[InvalidValue] = InvalidValue, *, finite: bool = True
) -> tuple[float, float]:
    """Return a lower and an upper bound, of which the upper is not below the lower; or raise InvalidValue."""
    bounds = items_of(value)
    if len(bounds) != 2:
        raise error(what, value, "has to be two numbers, the lower bound and the upper bound")
    low, high = (as_number(bound, what, error, finite=finite) for bound in bounds)
    if low > high:
        raise error(what, value, "has its lower bound above its upper bound", "Exchange the two.")
    return low, high


def as_picture_size(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> tuple[int, int]:
    """Return width and height of a picture [px], from a pair or from one number for both; or raise InvalidValue."""
    sides = (value, value) if isinstance(value, int | np.integer) else items_of(value)
    if len(sides) != 2:
        raise error(what, value, "has to be width and height, two whole numbers, or one for both")
    width, height = (as_whole(side, what, error, least=1, most=LARGEST_SIDE) for side in sides)
    return width, height


def as_names(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> tuple[str, ...]:
    """Return a list of names as a tuple, or raise InvalidValue; a single text would mean its letters."""
    names = tuple(value) if isinstance(value, set | frozenset | dict) else items_of(value)
    if not all(isinstance(name, str) for name in names) or (not names and not _is_empty(value)):
        raise error(what, value, "has to be a list of names")
    if isinstance(value, str | bytes):
        raise error(what, value, "has to be a list of names", f"Write [{value!r}] for one.")
    return tuple(str(name) for name in names)


def _is_empty(value: object) -> bool:
    return value.shape == (0,) if isinstance(value, np.ndarray) else isinstance(value, Collection) and len(value) == 0


def items_of(value: object) -> tuple[object, ...]:
    """Return the items of a list, a tuple or a one-dimensional array; nothing for everything else, text among it."""
    if isinstance(value, np.ndarray):
        return tuple(value) if value.ndim == 1 else ()
    return tuple(value) if isinstance(value, Sequence) and not isinstance(value, str | bytes) else ()


def as_text(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> str:
    """Return a text, or raise InvalidValue; no number is written out."""
    if not isinstance(value, str):
        raise error(what, value, "has to be a text")
    return value


def as_path(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> Path:
    """Return a path, from a text or a path; or raise InvalidValue."""
    if not isinstance(value, str | PathLike) or isinstance(text := fspath(value), bytes) or "\0" in text:
        raise error(what, value, "has to be a path: a text without the character 0, or a Path")
    try:
        lengths = [len(part) for part in fsencode(text).split(b"/")]
    except UnicodeEncodeError as failure:
        raise error(what, value, f"cannot be the name of a file: {failure.reason}") from failure
    if max(lengths) > LONGEST_NAME or sum(lengths) + len(lengths) > LONGEST_PATH:
        raise error(what, value, f"is too long: names have {LONGEST_NAME} bytes at most, paths {LONGEST_PATH}")
    return Path(text)


def as_function(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> None:
    """Raise InvalidValue unless `value` can be called, or is None."""
    if value is not None and not callable(value):
        raise error(what, value, "has to be a function, or None")


def as_several(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> tuple[Any, ...]:
    """Return what a list, a set or a generator holds, or raise InvalidValue; a text would be its letters."""
    if not isinstance(value, Iterable) or isinstance(value, str | bytes | np.ndarray):
        raise error(what, value, "has to be a list")
    return tuple(value)


def as_record(value: object, kind: type[KindT], what: str, error: type[InvalidValue] = InvalidValue) -> KindT:
    """Return `value`, or raise InvalidValue when it is no `kind`."""
    if not isinstance(value, kind):
        raise error(what, value, f"has to be {_one(kind)}", _MADE_BY.get(kind.__name__, ""))
    return value


def _one(kind: type) -> str:
    """Return what one of a class is called, with its article."""
    if kind in (bytes, dict):
        return kind.__name__
    return f"{'an' if kind.__name__[0] in 'AEIO' else 'a'} {kind.__name__}"


def _range_text(least: float, most: float, above: float = -math.inf) -> str:
    bounds = ((">=", least), (">", above), ("<=", most))
    parts = [f"{sign} {bound if isinstance(bound, int) else f'{bound:.6g}'}" for sign, bound in bounds if not math.isinf(bound)]
    return f" {' and '.join(parts)}" if parts else ""
