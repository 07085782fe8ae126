"""Checks of numbers at the border of the world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rlbench_pin.errors import InvalidActionError, RlbenchPinError
from rlbench_pin.spatial import FloatArray


class InvalidNumbers(RlbenchPinError, ValueError):
    """An array has the wrong shape, or holds NaN or infinity."""


def finite_vector(values: Sequence[float] | FloatArray, size: int, what: str) -> FloatArray:
    """Return a copy of `values` as a finite vector (size,).

    Raises:
        InvalidNumbers: Wrong shape, NaN or infinity.
    """
    vector = np.array(values, dtype=float)
    if vector.shape != (size,):
        raise InvalidNumbers(f"The {what} has shape {vector.shape}, not ({size},).")
    if not np.isfinite(vector).all():
        raise InvalidNumbers(f"The {what} is not finite: {vector.tolist()}.")
    return vector


def pose_vector(pose: Sequence[float] | FloatArray, what: str) -> FloatArray:
    """Return a copy of `pose` (7,) with a quaternion of norm 1.

    Raises:
        InvalidNumbers: Wrong shape, NaN or infinity, or a quaternion whose norm is off by more than 0.1 %.
    """
    vector = finite_vector(pose, 7, what)
    norm = float(np.linalg.norm(vector[3:]))
    if abs(norm - 1.0) > 1e-3:
        raise InvalidNumbers(f"The {what} has a quaternion of norm {norm:.4f}, not 1.")
    vector[3:] /= norm
    return vector


def whole_ratio(control_dt: float, timestep: float) -> int:
    """Return how many physics steps of length `timestep` [s] a control tick of length `control_dt` [s] has.

    Raises:
        ValueError: It is no whole number.
    """
    ratio = round(control_dt / timestep) if timestep > 0.0 else 0
    if ratio < 1 or abs(ratio * timestep - control_dt) > 1e-9:
        raise ValueError(f"A control tick of {control_dt} s is not a whole number of physics steps of {timestep} s.")
    return ratio


def action_vector(values: Sequence[float] | FloatArray, size: int, what: str) -> FloatArray:
    """Return a copy of a command as a finite vector (size,).

    Raises:
        InvalidActionError: Wrong shape, NaN or infinity.
    """
    try:
        return finite_vector(values, size, what)
    except (ValueError, TypeError) as error:
        raise InvalidActionError(str(error)) from error
