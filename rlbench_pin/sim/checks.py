"""Checks of numbers at the border of the world."""

from __future__ import annotations

from numpy.typing import ArrayLike

from rlbench_pin import values
from rlbench_pin.errors import InvalidActionError, InvalidValue
from rlbench_pin.spatial import FloatArray


class InvalidNumbers(InvalidValue):
    """An array has the wrong shape, or holds NaN or infinity."""


def finite_vector(value: ArrayLike, size: int, what: str) -> FloatArray:
    """Return a copy of `value` as a finite vector (size,).

    Raises:
        InvalidNumbers: Wrong shape, NaN or infinity.
    """
    return values.as_vector(value, size, f"The {what}", InvalidNumbers).copy()


def pose_vector(pose: ArrayLike, what: str) -> FloatArray:
    """Return a copy of `pose` (7,) with a quaternion of norm 1.

    Raises:
        InvalidNumbers: Wrong shape, NaN or infinity, or a quaternion whose norm is off by more than 0.1 %.
    """
    return values.as_pose(pose, f"The {what}", InvalidNumbers, tolerance=1e-3)


def color_values(color: ArrayLike) -> tuple[float, float, float, float]:
    """Return red, green, blue and alpha, which is 1 where it is not given.

    Raises:
        InvalidNumbers: It is not 3 or 4 numbers in 0..1.
    """
    array = values.as_array(color, "A colour", InvalidNumbers)
    if array.shape not in ((3,), (4,)) or not ((array >= 0.0) & (array <= 1.0)).all():
        raise InvalidNumbers("A colour", color, "has to be 3 or 4 numbers in 0..1")
    red, green, blue, alpha = (*array.tolist(), 1.0)[:4]
    return red, green, blue, alpha


def whole_ratio(control_dt: float, timestep: float) -> int:
    """Return how many physics steps of length `timestep` [s] a control tick of length `control_dt` [s] has.

    Raises:
        InvalidValue: It is no whole number, or a time is not finite and > 0 (also a ValueError).
    """
    control_dt, timestep = (
        values.as_number(t, what, above=0.0) for t, what in ((control_dt, "control_dt"), (timestep, "timestep"))
    )
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
