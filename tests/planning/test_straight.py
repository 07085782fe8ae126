"""Straight lines and curves of the tip."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.errors import NotStraight
from rlbench_pin.planning.path import curve_path, straight_path, through
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.spatial import above_table, compose, pose_at, rotation_distance


def distance_to_line(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distance of every point (m, 3) to the segment from a to b [m]."""
    t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(points - a - t[:, None] * (b - a), axis=1)


@pytest.mark.parametrize(
    "goal",
    [
        pose_at((0.3, 0.2, 0.9), np.pi, 0.0, 0.5 + np.pi),
        pose_at((0.1, -0.3, 1.1), np.pi, 0.3, -0.5 + np.pi),
        pose_at((0.5, 0.0, 0.8), np.pi, 0.0, np.pi),
        pose_at((0.278, 0.0, 1.2), -2.8, 0.0, np.pi),
    ],
)
def test_the_tip_keeps_to_the_line(model: RobotModel, goal: np.ndarray) -> None:
    """Between the solved configurations too, the tip is within 1 mm of the line, and its turn never exceeds the whole."""
    start = model.tip_pose(model.home)
    line = straight_path(model, model.home, goal)
    _, configurations = through(line, np.linspace(0.0, 1.0, len(line))).spread(0.004)
    poses = np.array([model.tip_pose(q) for q in configurations])
    assert distance_to_line(poses[:, :3], start[:3], goal[:3]).max() < 1e-3
    whole = rotation_distance(start, goal)
    for pose in poses[::20]:
        assert rotation_distance(start, pose) + rotation_distance(pose, goal) < whole + 5e-3
    np.testing.assert_allclose(poses[-1][:3], goal[:3], atol=1e-5)
    assert rotation_distance(poses[-1], goal) < 1e-4


def test_steps_are_small(model: RobotModel) -> None:
    """The arm does not flip on the way."""
    path = straight_path(model, model.home, pose_at((0.4, 0.3, 0.9), np.pi, 0.0, np.pi))
    assert np.abs(np.diff(path, axis=0)).max() < 0.2
    np.testing.assert_array_equal(path[0], model.home)


def test_a_line_out_of_reach_says_how_far_it_goes(model: RobotModel) -> None:
    """The error carries the fraction of the line that can be followed."""
    start = straight_path(model, model.home, pose_at((0.2, 0.0, 0.9), np.pi, 0.0, np.pi))[-1]
    with pytest.raises(NotStraight) as caught:
        straight_path(model, start, pose_at((1.0, 0.0, 0.9), np.pi, 0.0, np.pi))
    assert 0.3 < caught.value.fraction < 0.7


def test_an_obstacle_interrupts_the_line(model: RobotModel) -> None:
    """Configurations that are not free end it."""
    goal = pose_at((0.278, 0.0, above_table(0.148)), np.pi, 0.0, np.pi)

    def is_free(q: np.ndarray) -> bool:
        return bool(model.tip_pose(q)[2] > above_table(0.448))

    with pytest.raises(NotStraight, match="in the way") as caught:
        straight_path(model, model.home, goal, is_free)
    assert caught.value.fraction == pytest.approx((0.701 - 0.448) / (0.701 - 0.148), abs=0.05)


def test_a_curve_visits_its_poses(model: RobotModel) -> None:
    """The tip passes every pose of the row."""
    start = model.tip_pose(model.home)
    poses = [compose(start, pose_at((0.1 - 0.1 * np.cos(a), -0.1 * np.sin(a), 0.0))) for a in np.linspace(0.1, 3.0, 12)]
    tips = np.array([model.tip_pose(q) for q in curve_path(model, model.home, poses)])
    for pose in poses:
        assert np.linalg.norm(tips[:, :3] - pose[:3], axis=1).min() < 1e-5


def test_no_motion_is_a_line_too(model: RobotModel) -> None:
    """The pose where the tip is already is reached by standing still."""
    path = straight_path(model, model.home, model.tip_pose(model.home))
    np.testing.assert_allclose(path, np.tile(model.home, (len(path), 1)), atol=1e-6)
