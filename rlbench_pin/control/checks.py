"""Checks of the arguments of controllers: finite vectors of the right length, and poses with a nonzero quaternion."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from rlbench_pin import values
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_record

FARTHEST = 1e6
"""Upper bound of pose coordinates [m]."""
LARGEST_STATE = 1e4
"""Upper bound of joint positions [rad] and velocities [rad/s]; larger values are measurement errors."""
_FLOAT = np.dtype(float)


def check_made_of(model: object, config: object = None, kind: type = object) -> None:
    """Raise InvalidValue unless `model` is a RobotModel and `config` is of type `kind`."""
    as_record(model, RobotModel, "model")
    as_record(config, kind, "config")


def as_vector(value: ArrayLike, size: int, what: str, most: float | None = None) -> FloatArray:
    """Return `value` as a finite float64 vector of shape (size,), without a copy if it already is one.

    Raises:
        InvalidTarget: It has another shape, or contains NaN, infinity or a value beyond +-`most`.
    """
    return values.as_vector(value, size, what, InvalidTarget, most=most)


def as_state(q: ArrayLike, v: ArrayLike, size: int) -> tuple[FloatArray, FloatArray]:
    """Return configuration and joint velocity as finite float64 vectors of shape (size,).

    Raises:
        InvalidTarget: One of them has another shape, or contains NaN, infinity or a value beyond `LARGEST_STATE`.
    """
    plain = type(q) is type(v) is np.ndarray and q.dtype is v.dtype is _FLOAT and q.shape == v.shape == (size,)
    if plain and math.hypot(*q.tolist(), *v.tolist()) <= LARGEST_STATE:  # type: ignore[union-attr] # NaN shows in any length
        return q, v  # type: ignore[return-value]
    q = values.as_vector(q, size, "configuration", InvalidTarget, most=LARGEST_STATE)
    return q, values.as_vector(v, size, "joint velocity", InvalidTarget, most=LARGEST_STATE)


def as_placement(pose: ArrayLike, what: str = "target pose") -> pin.SE3:
    """Return a pose (7,) as the placement T_world_target, after the checks of `as_pose`."""
    return pin.XYZQUATToSE3(as_pose(pose, what))


def as_pose(pose: ArrayLike, what: str = "target pose") -> list[float]:
    """Return the seven numbers of a pose, with a normalised quaternion.

    Raises:
        InvalidTarget: It has another shape, contains NaN or infinity, or its quaternion has norm zero.
    """
    plain = type(pose) is np.ndarray and pose.dtype is _FLOAT and pose.shape == (7,)
    vector: FloatArray = pose if plain else as_vector(pose, 7, what)  # type: ignore[assignment]
    numbers: list[float] = vector.tolist()
    x, y, z, qx, qy, qz, qw = numbers
    square = qx * qx + qy * qy + qz * qz + qw * qw
    if not math.hypot(x, y, z, square) < FARTHEST:
        raise InvalidTarget(what, vector, f"has to be finite, with coordinates below {FARTHEST:g} m")
    if -1e-9 < square - 1.0 < 1e-9:
        return numbers
    if square < values.SMALLEST_NORM**2:
        raise InvalidTarget(what, vector, "has a quaternion of norm zero", "Pass x, y, z, qx, qy, qz, qw.")
    length = math.sqrt(square)
    return [x, y, z, qx / length, qy / length, qz / length, qw / length]
