"""Sets of equally good goals: symmetric grasps, regions of poses, and the ways of the redundant arm to hold one pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from rlbench_pin.errors import InvalidRequest
from rlbench_pin.planning.kinematics.ik import SAME, descend
from rlbench_pin.planning.requests import as_configuration, as_goal_pose, check_generator
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3, se3_to_pose
from rlbench_pin.values import as_number, as_vector, as_whole


def symmetric_poses(pose: PoseLike, order: int) -> list[FloatArray]:
    """Return the `order` poses (7,) that are alike for a hand or an object of that symmetry about the tip's z axis.

    Raises:
        InvalidRequest: `pose` is none, or `order` no whole number from 1 to 360.
    """
    T, order = pose_to_se3(as_goal_pose(pose, "pose")), as_whole(order, "order", InvalidRequest, least=1, most=360)
    turns = (pin.SE3(pin.utils.rotate("z", 2.0 * np.pi * k / order), np.zeros(3)) for k in range(order))
    return [se3_to_pose(T * turn) for turn in turns]


@dataclass(frozen=True, kw_only=True)
class PoseRegion:
    """All poses that differ from `center` by at most some lengths and angles along and about its own axes."""

    center: tuple[float, ...]
    """Pose (7,)."""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Half sizes of the box of positions [m]."""
    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Largest rotation about each axis [rad]."""

    def __post_init__(self) -> None:
        """Raise InvalidRequest unless there is a centre, and no size is negative."""
        as_goal_pose(self.center, "center of a region")
        for name in ("position", "rotation"):
            if as_vector(getattr(self, name), 3, f"PoseRegion.{name}", InvalidRequest).min() < 0.0:
                raise InvalidRequest(f"PoseRegion.{name}", getattr(self, name), "has to be three numbers >= 0")

    def sample(self, count: int, rng: np.random.Generator) -> list[FloatArray]:
        """Return `count` poses of the region, its centre first."""
        count = as_whole(count, "count", InvalidRequest, least=0, most=1_000_000)
        check_generator(rng)
        T = pose_to_se3(self.center)
        half = np.concatenate([self.position, self.rotation])
        offsets = rng.uniform(-half, half, (count, 6))
        offsets[:1] = 0.0
        return [se3_to_pose(T * pin.SE3(pin.exp3(offset[3:]), offset[:3])) for offset in offsets]


def self_motions(model: RobotModel, q: FloatArray, step: float = 0.3, count: int = 4) -> list[FloatArray]:
    """Return up to `count` configurations (n,) on each side that hold the tip of `q` (n,) where it is, by moving the elbow.

    Raises:
        InvalidRequest: NaN, a wrong shape, or no numbers.
        OutsideJointLimits: `q` is outside the joint limits.
    """
    q, step = as_configuration(model, q, "configuration"), as_number(step, "step", InvalidRequest, above=0.0)
    count = as_whole(count, "count", InvalidRequest, least=0, most=1000)
    target = model.tip_se3(q)
    found: list[FloatArray] = []
    for sign in (1.0, -1.0):
        here, direction = q, sign * _null_direction(model, q)
        for _ in range(count):
            end = descend(model, target, here + step * direction)
            if not end.converged or np.abs(end.q - here).max() < 0.3 * SAME:
                break
            following = _null_direction(model, end.q)
            direction = following if following @ direction > 0.0 else -following
            here = end.q
            found.append(here)
    return found


def _null_direction(model: RobotModel, q: FloatArray) -> FloatArray:
    """Return the joint motion (n,) of length 1 that leaves the tip where it is."""
    return np.linalg.svd(model.jacobian(q))[2][-1]
