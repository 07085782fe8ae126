"""What planning accepts: configurations within the joint limits, poses that mean a rotation, generators. Checked at its doors."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import ArrayLike

from rlbench_pin.errors import InvalidRequest, OutsideJointLimits
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, PoseLike
from rlbench_pin.values import SMALLEST_NORM, as_array, as_finite, as_flag, as_names, as_record, as_vector

FORGIVEN = 1e-3
"""How far beyond its limits a joint may be at the ends of a motion, which then begins or ends at the limit [rad]."""


def as_configuration(model: RobotModel, q: ArrayLike, what: str) -> FloatArray:
    """Return a configuration (n,), [rad], of an arm, as it was given.

    Args:
        model: The arm.
        q: The configuration.
        what: What it is called, such as `start configuration`.

    Raises:
        InvalidRequest: NaN, a wrong shape, or no numbers.
        OutsideJointLimits: A joint is beyond its limits by more than `FORGIVEN`; names the farthest.
    """
    as_record(model, RobotModel, "model", InvalidRequest)
    vector, limits = as_vector(q, model.size, f"The {what}", InvalidRequest), model.limits
    if not limits.contains(vector, FORGIVEN):
        worst = int(np.argmax(np.maximum(limits.lower - vector, vector - limits.upper)))
        limit = limits.lower[worst] if vector[worst] < limits.lower[worst] else limits.upper[worst]
        raise OutsideJointLimits(what, model.description.arm_joints[worst], float(vector[worst]), float(limit), FORGIVEN)
    return vector


def as_goal_poses(pose: PoseLike | Sequence[PoseLike], what: str = "goal") -> list[FloatArray]:
    """Return a list of tip poses (7,) from one or several.

    Raises:
        InvalidRequest: There is none, or one has a wrong shape, NaN, or a quaternion of norm zero.
    """
    given = as_array(pose, f"The {what}", InvalidRequest)
    poses = given[None] if given.ndim == 1 else given
    if poses.ndim != 2 or poses.shape[1] != 7 or not len(poses):
        raise InvalidRequest(f"The {what}", pose, f"has to be a pose (7,) or several (m, 7), not of shape {given.shape}")
    as_finite(poses, f"The {what}", InvalidRequest)
    norms = np.linalg.norm(poses[:, 3:], axis=1)
    if not norms.min() >= SMALLEST_NORM or not np.isfinite(norms).all():
        raise InvalidRequest(f"The {what}", pose, "has a quaternion of norm zero", "The order is x, y, z, w.")
    return list(poses)


def as_goal_pose(pose: PoseLike, what: str = "goal") -> FloatArray:
    """Return one tip pose (7,) as it was given; raises as `as_goal_poses`."""
    return as_goal_poses(as_vector(pose, 7, f"The {what}", InvalidRequest), what)[0]


def check_generator(rng: object) -> None:
    """Raise InvalidRequest unless `rng` is a generator of numpy."""
    if not isinstance(rng, np.random.Generator):
        raise InvalidRequest("rng", rng, "has to be a generator of numpy", "`np.random.default_rng(0)` makes one.")


def check_callable(function: object, what: str) -> None:
    """Raise InvalidRequest unless `function` can be called, or is None."""
    if function is not None and not callable(function):
        raise InvalidRequest(what, function, "has to be a function that takes a configuration (n,), or None")


def check_switches(**switches: object) -> None:
    """Raise InvalidRequest unless each is True or False."""
    for name, switch in switches.items():
        as_flag(switch, name, InvalidRequest)


def check_options(rng: object, allowed: Collection[str], free: object) -> None:
    """Raise InvalidRequest unless `rng` is a generator, `allowed` a collection of names, no text, and `free` True or False."""
    check_switches(ignore_collisions=free)
    check_generator(rng)
    as_names(allowed, "allowed, the bodies that may be touched,", InvalidRequest)
