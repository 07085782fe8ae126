"""Checks of arrays: vectors, rows, poses."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rlbench_pin.errors import InvalidValue

FloatArray = NDArray[np.float64]
SMALLEST_NORM = 1e-3
"""A quaternion shorter than this has no direction worth trusting."""
_FLOAT = np.dtype(float)
_NUMERIC = "biuf"
_BROKEN = (TypeError, ValueError, OverflowError, AttributeError, RuntimeError, MemoryError)
"""What objects raise that cannot be made an array."""


def as_array(value: object, what: str, error: type[InvalidValue] = InvalidValue) -> FloatArray:
    """Return `value` as a float64 array of any shape; the caller's array itself when it is one.

    Raises:
        InvalidValue: It is complex, text, dates, objects, ragged, or an array of which something is masked.
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
        InvalidValue: It is no array of numbers, has another shape, or holds NaN, infinity or a number beyond +-`most`.
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
        raise error(what, value, f"has to hold numbers from {-most:g} to {most:g}")
    return vector


def as_rows(value: ArrayLike, size: int, what: str, error: type[InvalidValue] = InvalidValue, *, least: int = 1) -> FloatArray:
    """Return `value` as a finite float64 array (m, size) of at least `least` rows, or raise InvalidValue."""
    rows = as_array(value, what, error)
    if rows.ndim != 2 or rows.shape[1] != size or len(rows) < least:
        raise error(what, value, f"has to have shape (m, {size}) with at least {least} rows, not {rows.shape}")
    return as_finite(rows, what, error)


def as_finite(array: FloatArray, what: str, error: type[InvalidValue] = InvalidValue) -> FloatArray:
    """Return `array` itself, or raise InvalidValue when it holds NaN or infinity; names the first places."""
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
        what: What it is called.
        error: What to raise.
        tolerance: By how much the length of the quaternion may differ from 1; any length but zero without one.

    Raises:
        InvalidValue: It has another shape, holds NaN or infinity, or its quaternion has a wrong length.
    """
    pose = as_vector(value, 7, what, error)
    norm = float(np.linalg.norm(pose[3:]))
    if not SMALLEST_NORM <= norm < math.inf:
        raise error(what, value, f"has a quaternion of norm zero or nearly so ({norm:.3g})", "The order is x, y, z, w.")
    if abs(norm - 1.0) > tolerance:
        raise error(what, value, f"has a quaternion of norm {norm:.4f}, not 1", "Divide it by its norm.")
    return np.concatenate([pose[:3], pose[3:] / norm])
