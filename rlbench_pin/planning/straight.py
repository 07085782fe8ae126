"""Cartesian curves: the tip follows a line or a sequence of poses, the joints follow by small steps."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pinocchio as pin
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from rlbench_pin.errors import NotStraight
from rlbench_pin.planning.kinematics import descend
from rlbench_pin.planning.path import IsFree
from rlbench_pin.planning.requests import as_configuration, as_goal_pose, as_goal_poses, check_callable
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import FloatArray, PoseLike, pose_to_se3

STEP_POSITION = 0.02
"""Distance of the tip between two solved configurations [m]."""
STEP_ROTATION = 0.1
"""Angle of the tip between two solved configurations [rad]."""
MOST_STEPS = 5000
"""Longer lines and curves, 100 m or 80 turns, are beyond any arm."""
LARGEST_JUMP = 0.4
"""More joint motion than this in one step means that the arm would flip [rad]."""


def straight_path(model: RobotModel, q_start: FloatArray, goal: PoseLike, is_free: IsFree | None = None) -> FloatArray:
    """Return configurations (m, n) whose tip goes straight, and turns evenly, from where it is to `goal` (7,).

    Raises:
        InvalidRequest: NaN, a wrong shape, or no numbers.
        OutsideJointLimits: The start is outside the joint limits.
        NotStraight: A joint limit, a singularity or a collision interrupts the line.
    """
    q_start, goal = as_configuration(model, q_start, "start configuration"), as_goal_pose(goal)
    check_callable(is_free, "is_free")
    return _follow(model, q_start, _line(model.tip_se3(q_start), pose_to_se3(goal)), is_free)


def curve_path(model: RobotModel, q_start: FloatArray, poses: Sequence[PoseLike], is_free: IsFree | None = None) -> FloatArray:
    """Return configurations (m, n) whose tip passes `poses` (7,) one after the other, on a smooth curve.

    Raises:
        InvalidRequest: NaN, a wrong shape, or no poses.
        OutsideJointLimits: As in `straight_path`.
        NotStraight: As in `straight_path`.
    """
    q_start, poses = as_configuration(model, q_start, "start configuration"), as_goal_poses(poses, "curve")
    check_callable(is_free, "is_free")
    targets = _curve([model.tip_se3(q_start), *(pose_to_se3(pose) for pose in poses)])
    return _follow(model, q_start, targets, is_free)


def _line(start: pin.SE3, goal: pin.SE3) -> list[pin.SE3]:
    """Return the poses after `start` up to `goal`, evenly spaced, position and orientation interpolated separately."""
    shift = goal.translation - start.translation
    turn = pin.log3(start.rotation.T @ goal.rotation)
    count = max(4, int(np.ceil(_checked_size(_size(start, goal)))))
    line = [pin.SE3(start.rotation @ pin.exp3(k / count * turn), start.translation + k / count * shift) for k in range(1, count)]
    return [*line, goal]


def _curve(stations: Sequence[pin.SE3]) -> list[pin.SE3]:
    """Return the poses after the first station on a smooth curve through all of them; a line when there are only two."""
    gaps = [_size(a, b) for a, b in pairwise(stations)]
    _checked_size(sum(gaps))
    stations = [stations[0], *(b for b, gap in zip(stations[1:], gaps, strict=True) if gap > 1e-3)]
    gaps = [gap for gap in gaps if gap > 1e-3]
    if len(stations) < 3:
        return _line(stations[0], stations[-1])
    at = np.concatenate([[0.0], np.cumsum(gaps)])
    positions = CubicSpline(at, np.array([T.translation for T in stations]))
    rotations = RotationSpline(at, Rotation.from_matrix(np.array([T.rotation for T in stations])))
    shares = [np.linspace(a, b, max(1, int(np.ceil(b - a))) + 1)[1:] for a, b in pairwise(at)]
    u = np.concatenate(shares)
    return [pin.SE3(R, x) for R, x in zip(rotations(u).as_matrix(), positions(u), strict=True)]


def _size(a: pin.SE3, b: pin.SE3) -> float:
    """Return how many steps lie between two poses."""
    turn = np.linalg.norm(pin.log3(a.rotation.T @ b.rotation))
    return float(max(np.linalg.norm(b.translation - a.translation) / STEP_POSITION, turn / STEP_ROTATION))


def _checked_size(steps: float) -> float:
    if not steps <= MOST_STEPS:
        raise NotStraight(0.0, f"it is {steps * STEP_POSITION:.4g} m long, or turns as much, and the arm ends before")
    return steps


def _follow(model: RobotModel, q_start: FloatArray, targets: Sequence[pin.SE3], is_free: IsFree | None) -> FloatArray:
    """Solve one target after the other, each from a guess that extends the last step."""
    q, last = np.array(q_start), np.array(q_start)
    path = [q]
    for k, target in enumerate(targets):
        end = descend(model, target, 2.0 * q - last, iterations=12)
        if not end.converged:
            raise NotStraight(k / len(targets), "the arm cannot reach on, a joint limit or the end of its reach is met")
        if np.abs(end.q - q).max() > LARGEST_JUMP:
            raise NotStraight(k / len(targets), "the arm would have to flip, it is close to a singular configuration")
        if is_free is not None and k < len(targets) - 1 and not is_free(end.q):
            raise NotStraight(k / len(targets), "something is in the way")
        last, q = q, end.q
        path.append(q)
    return np.array(path)
