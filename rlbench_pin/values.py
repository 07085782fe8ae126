"""Checks of arguments: numbers, whole numbers, switches, arrays, poses, seeds, sizes, settings.

Every check returns the value in the form that the package uses, or raises `InvalidValue` or a given subclass. The error names
the argument, its value and the valid values. Texts, booleans and dates are never converted to numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import partial, wraps
from inspect import signature
from os import PathLike, fsencode, fspath
from pathlib import Path
from typing import Any, ClassVar, ParamSpec, TypeGuard, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rlbench_pin.errors import InvalidActionError, InvalidValue, UnknownArgument, UnknownName, UnknownSetting

KindT = TypeVar("KindT")
LARGEST_SEED = 2**63 - 1
"""Stored episodes keep their seed in 64 bits, with a sign."""
LARGEST_SIDE = 8192
"""Images have at most so many columns and rows [px]."""
LONGEST_NAME, LONGEST_PATH = 255, 4095
"""Bytes of file names and paths of Linux."""
_NO_NUMBERS = (bool, np.bool_, np.timedelta64)
"""Types that numpy or Python treat as integers and this package does not."""
_NUMBERS = (float, int, np.floating, np.integer)
_MADE_BY = {
    "Generator": "Create one with `np.random.default_rng(seed)`.",
    "Demo": "Get one from `task.get_demos(1)` or `read_demo(path)`.",
}
"""Class -> how to create an instance, for error messages."""


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
        value: A number of Python or numpy; booleans and texts are refused.
        what: Name of the argument, for the error.
        error: Class of the error.
        least: Smallest valid value.
        most: Largest valid value.
        above: Exclusive lower bound.
        finite: Refuse infinity. NaN is always refused.

    Raises:
        InvalidValue: The value is not a number, or out of range.
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
    """Whether a value is a whole number of Python or numpy; True, 1.0, "1" and a time difference are not."""
    return isinstance(value, int | np.integer) and not isinstance(value, _NO_NUMBERS)


def as_whole(
    value: object, what: str, error: type[InvalidValue] = InvalidValue, *, least: int | None = None, most: int | None = None
) -> int:
    """Return `value` as an int of Python, which cannot overflow.

    Args:
        value: A whole number of Python or numpy; 1.5, True and "1" are refused.
        what: Name of the argument, for the error.
        error: Class of the error.
        least: Smallest valid value.
        most: Largest valid value.

    Raises:
        InvalidValue: The value is not a whole number, or out of range.
    """
    whole = is_whole(value)
    number = int(value) if is_whole(value) else 0
    if not whole or (least is not None and number < least) or (most is not None and number > most):
        low, high = -math.inf if least is None else least, math.inf if most is None else most
        raise error(what, value, f"has to be a whole number{_range_text(low, high)}")
    return number


def as_flag(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> bool:
    """Return a boolean of Python or numpy, or 0 or 1, as a bool; or raise InvalidValue."""
    if isinstance(value, np.timedelta64) or not isinstance(value, bool | np.bool_ | int | np.integer) or value not in (0, 1):
        raise error(what, value, "has to be True or False")
    return bool(value)


def as_choice(value: object, what: str, choices: Collection[str]) -> str:
    """Return `value` if it is one of the choices.

    Raises:
        UnknownName: It is not a choice; the message names the nearest one.
    """
    if not isinstance(value, str) or value not in choices:
        raise UnknownName(what, value, tuple(choices))  # type: ignore[arg-type] # it shows whatever it is
    return value


ParamsT = ParamSpec("ParamsT")
ResultT = TypeVar("ResultT")


def names_arguments(function: Callable[ParamsT, ResultT]) -> Callable[ParamsT, ResultT]:
    """Return a function that raises UnknownArgument for an unknown argument; the message names the nearest known one."""
    known = tuple(name for name in signature(function).parameters if name != "self")
    owner = function.__qualname__.removesuffix(".__init__")

    @wraps(function)
    def call(*args: ParamsT.args, **named: ParamsT.kwargs) -> ResultT:
        for name in named:
            if name not in known:
                raise UnknownArgument(str(UnknownName(f"argument of {owner}", name, known)))
        return function(*args, **named)

    return call


def as_seed(value: object, what: str = "seed", error: type[InvalidValue] = InvalidValue) -> int:
    """Return a seed as an int, 0 <= seed < 2^63, the range of episode files; or raise InvalidValue."""
    return as_whole(value, what, error, least=0, most=LARGEST_SEED)


def as_interval(
    value: object, what: str, error: type[InvalidValue] = InvalidValue, *, finite: bool = True
) -> tuple[float, float]:
    """Return a lower and an upper bound with lower <= upper, or raise InvalidValue."""
    bounds = items_of(value)
    if len(bounds) != 2:
        raise error(what, value, "has to be two numbers, the lower bound and the upper bound")
    low, high = (as_number(bound, what, error, finite=finite) for bound in bounds)
    if low > high:
        raise error(what, value, "has its lower bound above its upper bound", "Exchange the two.")
    return low, high


def as_image_size(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> tuple[int, int]:
    """Return width and height of an image [px], from a pair or from one number for both; or raise InvalidValue."""
    sides = (value, value) if isinstance(value, int | np.integer) else items_of(value)
    if len(sides) != 2:
        raise error(what, value, "has to be width and height, two whole numbers, or one for both")
    width, height = (as_whole(side, what, error, least=1, most=LARGEST_SIDE) for side in sides)
    return width, height


def as_names(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> tuple[str, ...]:
    """Return a list of names as a tuple, or raise InvalidValue; a single text is refused."""
    names = tuple(value) if isinstance(value, set | frozenset | dict) else items_of(value)
    if not all(isinstance(name, str) for name in names) or (not names and not _is_empty(value)):
        raise error(what, value, "has to be a list of names")
    if isinstance(value, str | bytes):
        raise error(what, value, "has to be a list of names", f"Write [{value!r}] for one name.")
    return tuple(str(name) for name in names)


def _is_empty(value: object) -> bool:
    return value.shape == (0,) if isinstance(value, np.ndarray) else isinstance(value, Collection) and len(value) == 0


def items_of(value: object) -> tuple[object, ...]:
    """Return the items of a list, a tuple or a one-dimensional array; empty for other types, such as text."""
    if isinstance(value, np.ndarray):
        return tuple(value) if value.ndim == 1 else ()
    return tuple(value) if isinstance(value, Sequence) and not isinstance(value, str | bytes) else ()


def as_text(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> str:
    """Return a text, or raise InvalidValue; numbers are not converted."""
    if not isinstance(value, str):
        raise error(what, value, "has to be a text")
    return value


def as_path(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> Path:
    """Return a path, from a text or a path; or raise InvalidValue."""
    if not isinstance(value, str | PathLike) or isinstance(text := fspath(value), bytes) or "\0" in text:
        raise error(what, value, "has to be a path: a Path, or a text without null characters")
    try:
        lengths = [len(part) for part in fsencode(text).split(b"/")]
    except UnicodeEncodeError as failure:
        raise error(what, value, f"cannot be the name of a file: {failure.reason}") from failure
    if max(lengths) > LONGEST_NAME or sum(lengths) + len(lengths) > LONGEST_PATH:
        raise error(what, value, f"is too long: names have at most {LONGEST_NAME} bytes, paths {LONGEST_PATH}")
    return Path(text)


def as_function(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> None:
    """Raise InvalidValue unless `value` can be called, or is None."""
    if value is not None and not callable(value):
        raise error(what, value, "has to be a function, or None")


def as_several(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> tuple[Any, ...]:
    """Return the items of a list, a set or a generator, or raise InvalidValue; a text is refused."""
    if not isinstance(value, Iterable) or isinstance(value, str | bytes | np.ndarray):
        raise error(what, value, "has to be a list")
    return tuple(value)


def as_record(value: object, kind: type[KindT], what: str, error: type[InvalidValue] = InvalidValue) -> KindT:
    """Return `value`, or raise InvalidValue when it is not a `kind`."""
    if not isinstance(value, kind):
        raise error(what, value, f"has to be {_one(kind)}", _MADE_BY.get(kind.__name__, ""))
    return value


def _one(kind: type) -> str:
    """Return the name of a class with its article."""
    if kind in (bytes, dict):
        return kind.__name__
    return f"{'an' if kind.__name__[0] in 'AEIO' else 'a'} {kind.__name__}"


def _range_text(least: float, most: float, above: float = -math.inf) -> str:
    bounds = ((">=", least), (">", above), ("<=", most))
    parts = [f"{sign} {bound if isinstance(bound, int) else f'{bound:.6g}'}" for sign, bound in bounds if not math.isinf(bound)]
    return f" {' and '.join(parts)}" if parts else ""


FloatArray = NDArray[np.float64]
SMALLEST_NORM = 1e-3
"""Smallest norm of a quaternion whose direction is reliable."""
_FLOAT = np.dtype(float)
_NUMERIC = "biuf"
_BROKEN = (TypeError, ValueError, OverflowError, AttributeError, RuntimeError, MemoryError)
"""Errors of objects that cannot be made an array."""


def as_array(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> FloatArray:
    """Return `value` as a float64 array of any shape; the caller's array itself when it is one.

    Raises:
        InvalidValue: It has complex numbers, texts, dates, objects or masked numbers, or is ragged.
    """
    if type(value) is np.ndarray and value.dtype is _FLOAT:
        return value
    if _is_masked(value):
        raise error(what, value, "has masked numbers", "Fill them in, for example with `filled(0.0)`.")
    try:
        array = np.asarray(value)
        if array.dtype.kind in _NUMERIC:
            return array.astype(float, copy=False)
    except _BROKEN as failure:
        raise error(what, value, "has to be an array of numbers") from failure
    raise error(what, value, f"has to be an array of real numbers, not of {_kind_text(array)}")


def _is_masked(value: object) -> bool:
    """Whether numbers of an array, or of arrays in a list, are masked."""
    parts = value if isinstance(value, list | tuple) else (value,)
    return any(isinstance(part, np.ma.MaskedArray) and np.ma.is_masked(part) for part in parts)


def _kind_text(array: NDArray) -> str:
    kinds = {"c": "complex numbers", "U": "text", "S": "text", "M": "dates", "m": "time spans", "O": "objects"}
    return kinds.get(array.dtype.kind, str(array.dtype))


def as_vector(
    value: ArrayLike, size: int, what: str, error: type[InvalidValue] = InvalidValue, *, most: float | None = None
) -> FloatArray:
    """Return `value` as a finite float64 vector of shape (size,); the caller's array itself when it is one.

    Raises:
        InvalidValue: It is not an array of numbers, has another shape, or contains NaN, infinity or a number beyond +-`most`.
    """
    if type(value) is np.ndarray and value.dtype is _FLOAT and value.shape == (size,):
        numbers = value.tolist()  # NaN and infinity show in any sum, and in any length
        if math.isfinite(sum(numbers)) if most is None else math.hypot(*numbers) <= most:
            return value
    vector = as_array(value, what, error)
    if vector.shape != (size,):
        raise error(what, value, f"has to have shape ({size},), not {vector.shape}")
    as_finite(vector, what, error)
    if most is not None and size and np.abs(vector).max() > most:
        raise error(what, value, f"has to have numbers from {-most:g} to {most:g}")
    return vector


def as_rows(value: ArrayLike, size: int, what: str, error: type[InvalidValue] = InvalidValue, *, least: int = 1) -> FloatArray:
    """Return `value` as a finite float64 array (m, size) of at least `least` rows, or raise InvalidValue."""
    rows = as_array(value, what, error)
    if rows.ndim != 2 or rows.shape[1] != size or len(rows) < least:
        raise error(what, value, f"has to have shape (m, {size}) with at least {least} rows, not {rows.shape}")
    return as_finite(rows, what, error)


def as_finite(array: FloatArray, what: str, error: type[InvalidValue] = InvalidValue) -> FloatArray:
    """Return `array` itself, or raise InvalidValue if it has NaN or infinity; the message names the first indices."""
    good = np.isfinite(array)
    if not good.all():
        places = [place[0] if len(place) == 1 else tuple(place) for place in np.argwhere(~good)[:8].tolist()]
        where = f"; NaN or infinity is at {', '.join(map(str, places))}" if array.ndim else ""
        raise error(what, array, f"has to be finite{where}")
    return array


def as_pose(
    value: ArrayLike, what: str = "pose", error: type[InvalidValue] = InvalidValue, *, tolerance: float = math.inf
) -> FloatArray:
    """Return a pose (7,) as a new array whose quaternion has length 1.

    Args:
        value: Position and quaternion x, y, z, w.
        what: Name of the argument, for the error.
        error: Class of the error.
        tolerance: Largest difference of the norm of the quaternion from 1; by default any norm but zero is valid.

    Raises:
        InvalidValue: It has another shape, contains NaN or infinity, or its quaternion has a wrong norm.
    """
    pose = as_vector(value, 7, what, error)
    norm = float(np.linalg.norm(pose[3:]))
    if not SMALLEST_NORM <= norm < math.inf:
        raise error(what, value, f"has a quaternion of norm zero or nearly so ({norm:.3g})", "The order is x, y, z, w.")
    if abs(norm - 1.0) > tolerance:
        raise error(what, value, f"has a quaternion of norm {norm:.4f}, not 1", "Divide it by its norm.")
    return np.concatenate([pose[:3], pose[3:] / norm])


Rule = Callable[[object, str], object]
"""Function of a value and its name: returns the value to store, or raises InvalidValue."""
POSITIVE: Rule = partial(as_number, above=0.0)
NOT_NEGATIVE: Rule = partial(as_number, least=0.0)
FLAG: Rule = as_flag


LARGEST_COUNT = 2**31 - 1
"""Largest value of settings that are counts."""


def counted(least: int, most: int = LARGEST_COUNT) -> Rule:
    """Return the rule of whole numbers from `least` to `most`."""
    return partial(as_whole, least=least, most=most)


def one_of(*choices: str) -> Rule:
    """Return the rule of a word that is one of the choices."""

    def rule(value: object, what: str) -> str:
        if not isinstance(value, str) or value not in choices:
            raise InvalidValue(what, value, f"has to be one of {', '.join(choices)}")
        return value

    return rule


def record_of(kind: type) -> Rule:
    """Return the rule of records of one class."""

    def rule(value: object, what: str) -> object:
        return as_record(value, kind, what)

    return rule


def ruled(*rules: tuple[Rule, str]) -> dict[str, Rule]:
    """Return name -> rule from pairs of a rule and its names, separated by blanks."""
    return {name: rule for rule, names in rules for name in names.split()}


def check_settings(settings: object, rules: Mapping[str, Rule]) -> None:
    """Raise InvalidValue unless every attribute of a record follows its rule; frozen records call this after `__init__`."""
    for name, rule in rules.items():
        rule(getattr(settings, name), f"{type(settings).__name__}.{name}")


class Settings:
    """Base of settings that may change at any time: unknown attributes are refused, values are checked when they are set.

    Known attributes are the fields of the dataclass, attributes that the classes define or annotate, and names with an
    underscore.
    """

    rules: ClassVar[Mapping[str, Rule]] = {}
    """Attribute -> how it is checked; what is not named is taken as it is."""
    closed: ClassVar[bool] = True
    """Whether unknown attributes are refused."""

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute.

        Raises:
            UnknownSetting: There is no such setting; the message names the nearest one (also an AttributeError).
            InvalidValue: The value is invalid.
        """
        rule = self.rules.get(name)
        if rule is not None:
            value = rule(value, f"{type(self).__name__}.{name}")
        elif self.closed and not name.startswith("_") and name not in (known := _known_settings(type(self))):
            raise UnknownSetting(type(self).__name__, name, known)
        super().__setattr__(name, value)


def _known_settings(kind: type) -> tuple[str, ...]:
    """Return the names that instances of a settings class may have."""
    named = [f.name for f in fields(kind)] if is_dataclass(kind) else []
    named += [name for base in kind.__mro__[:-1] for name in (*vars(base), *vars(base).get("__annotations__", ()))]
    names = dict.fromkeys(name for name in named if not name.startswith("_") and name not in ("rules", "closed"))
    return tuple(name for name in names if not callable(getattr(kind, name, None)))


class InvalidNumbers(InvalidValue):
    """An array has the wrong shape, or contains NaN or infinity."""


def finite_vector(value: ArrayLike, size: int, what: str) -> FloatArray:
    """Return a copy of `value` as a finite vector (size,).

    Raises:
        InvalidNumbers: Wrong shape, NaN or infinity.
    """
    return as_vector(value, size, f"The {what}", InvalidNumbers).copy()


def pose_vector(pose: ArrayLike, what: str) -> FloatArray:
    """Return a copy of `pose` (7,) with a quaternion of norm 1.

    Raises:
        InvalidNumbers: Wrong shape, NaN or infinity, or a quaternion whose norm is off by more than 0.1 %.
    """
    return as_pose(pose, f"The {what}", InvalidNumbers, tolerance=1e-3)


def color_values(color: ArrayLike) -> tuple[float, float, float, float]:
    """Return red, green, blue and alpha; the default of alpha is 1.

    Raises:
        InvalidNumbers: They are not 3 or 4 numbers in 0..1.
    """
    array = as_array(color, "A colour", InvalidNumbers)
    if array.shape not in ((3,), (4,)) or not ((array >= 0.0) & (array <= 1.0)).all():
        raise InvalidNumbers("A colour", color, "has to be 3 or 4 numbers in 0..1")
    red, green, blue, alpha = (*array.tolist(), 1.0)[:4]
    return red, green, blue, alpha


def whole_ratio(control_dt: float, timestep: float) -> int:
    """Return the number of physics steps of length `timestep` [s] in a control tick of length `control_dt` [s].

    Raises:
        InvalidValue: The ratio is not a whole number, or a time is not finite and > 0 (also a ValueError).
    """
    control_dt, timestep = (as_number(t, what, above=0.0) for t, what in ((control_dt, "control_dt"), (timestep, "timestep")))
    ratio = round(control_dt / timestep) if control_dt < 1e6 * timestep else 0
    if ratio < 1 or abs(ratio * timestep - control_dt) > 1e-9:
        raise InvalidValue(
            "A control tick", control_dt, f"has to be a whole number of physics steps of {timestep} s, at most 1e6"
        )
    return ratio


def action_vector(value: ArrayLike, size: int, what: str) -> FloatArray:
    """Return a copy of a command as a finite vector (size,).

    Raises:
        InvalidActionError: Wrong shape, NaN or infinity.
    """
    try:
        return finite_vector(value, size, what)
    except InvalidNumbers as error:
        raise InvalidActionError(str(error)) from error
