"""Timing of paths."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.planning.path import along
from rlbench_pin.planning.straight import straight_spline
from rlbench_pin.planning.timing import ArcLimits, retime
from rlbench_pin.robot.model import JointLimits, RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from rlbench_pin.spatial import pose_at


def every_millisecond(trajectory: Trajectory) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sample q, v, a on a grid of 1 ms."""
    samples = [trajectory.sample(t) for t in np.arange(0.0, trajectory.duration, 1e-3)]
    q, v, a = (np.array(x) for x in zip(*samples, strict=True))
    return q, v, a


@pytest.mark.parametrize("seed", range(12))
def test_limits_hold_at_every_millisecond(limits: JointLimits, seed: int) -> None:
    """Velocity and acceleration stay within their limits, also when differenced from what is commanded."""
    rng = np.random.default_rng(seed)
    vertices = np.cumsum(rng.uniform(-0.6, 0.6, (rng.integers(2, 7), 7)), axis=0)
    q, v, a = every_millisecond(retime(along(vertices, 0.2), limits))
    assert (np.abs(v) <= limits.velocity).all()
    assert (np.abs(a) <= limits.acceleration).all()
    assert (np.abs(np.diff(q, axis=0)) / 1e-3 <= limits.velocity * 1.001).all()
    assert (np.abs(np.diff(v, axis=0)) / 1e-3 <= limits.acceleration * 1.01).all()


def test_limits_hold_on_a_line_of_the_tip(model: RobotModel, limits: JointLimits) -> None:
    """The same is true where joint velocities change along the way."""
    _, v, a = every_millisecond(retime(straight_spline(model, model.home, pose_at((0.35, 0.3, 0.85), np.pi, 0.0, np.pi)), limits))
    assert (np.abs(v) <= limits.velocity).all()
    assert (np.abs(a) <= limits.acceleration).all()


def test_it_rests_at_both_ends(limits: JointLimits) -> None:
    """The trajectory starts and ends exactly at the path's ends, without velocity."""
    ends = np.array([np.zeros(7), np.full(7, 0.5)])
    trajectory = retime(ends, limits)
    np.testing.assert_allclose(trajectory.q[[0, -1]], ends, atol=1e-12)
    np.testing.assert_array_equal(trajectory.v[[0, -1]], np.zeros((2, 7)))


def test_it_is_nearly_as_fast_as_possible(limits: JointLimits) -> None:
    """A line is driven with a trapezoid of velocity, within a few per cent of the fastest."""
    trajectory = retime(np.array([np.zeros(7), np.full(7, 1.0)]), limits)
    fastest = 1.0 / 1.0 + 1.0 / 4.0
    assert fastest <= trajectory.duration < 1.05 * fastest


def test_the_slowest_joint_decides() -> None:
    """Each joint has its own limit."""
    one = np.ones(2)
    limits = JointLimits(-one, one, np.array([1.0, 0.1]), np.array([4.0, 4.0]), one)
    assert retime(np.array([[0.0, 0.0], [0.5, 0.5]]), limits).duration > 5.0


@pytest.mark.parametrize("seed", range(8))
def test_limits_along_the_arc_hold_at_every_millisecond(limits: JointLimits, seed: int) -> None:
    """The norm of the joint velocity and its change stay within their limits, beside those of the joints, and are used."""
    rng = np.random.default_rng(seed)
    vertices = np.cumsum(rng.uniform(-0.6, 0.6, (rng.integers(2, 7), 7)), axis=0)
    arc = ArcLimits(0.7, 1.5)
    for jerk_time in (0.0, 0.1):
        _, v, a = every_millisecond(retime(along(vertices, 0.2), limits, arc=arc, jerk_time=jerk_time))
        speed = np.linalg.norm(v, axis=1)
        assert 0.6 < speed.max() <= arc.velocity + 1e-9
        assert np.abs(np.diff(speed)).max() / 1e-3 <= 1.01 * arc.acceleration
        assert (np.abs(v) <= limits.velocity).all() and (np.abs(a) <= limits.acceleration).all()


def test_a_line_is_as_long_as_the_arc_says(limits: JointLimits) -> None:
    """A trapezoid of the speed along the arc, within a few per cent of the fastest; a joint limit slows it further."""
    line = np.array([np.zeros(7), np.full(7, 1.0)])
    fastest = np.sqrt(7.0) / 1.0 + 1.0 / 4.0
    assert fastest <= retime(line, limits, arc=ArcLimits(1.0, 4.0)).duration < 1.03 * fastest
    slow = limits.capped(0.2, 4.0)
    assert retime(line, slow, arc=ArcLimits(1.0, 4.0)).duration > 5.0


def test_short_motions_keep_the_limits_along_the_arc(limits: JointLimits) -> None:
    """Those that are timed by a polynomial, too."""
    arc = ArcLimits(0.01, 0.05)
    _, v, a = every_millisecond(retime(np.array([np.zeros(7), np.full(7, 1e-3)]), limits, arc=arc))
    assert 0.5 * arc.velocity < np.linalg.norm(v, axis=1).max() <= arc.velocity
    assert np.linalg.norm(a, axis=1).max() <= arc.acceleration


def test_standing_still_takes_no_time(limits: JointLimits) -> None:
    """A path without length has one sample, and it can be asked for any time."""
    trajectory = retime(np.tile(np.linspace(0.0, 1.0, 7), (3, 1)), limits)
    assert trajectory.duration == 0.0
    np.testing.assert_array_equal(trajectory.sample(0.5)[0], np.linspace(0.0, 1.0, 7))


def test_tiny_motions_can_be_timed(limits: JointLimits) -> None:
    """A motion of a hair's breadth is timed too."""
    for size in (1e-8, 1e-5, 1e-3):
        trajectory = retime(np.array([np.zeros(7), np.full(7, size)]), limits)
        np.testing.assert_allclose(trajectory.q[-1], size, rtol=1e-6)
        assert trajectory.duration < 0.1
        every = every_millisecond(trajectory)
        assert (np.abs(every[1]) <= limits.velocity).all()
        assert (np.abs(every[2]) <= limits.acceleration).all()


def test_no_path_is_passed_almost_at_a_standstill(limits: JointLimits) -> None:
    """Where TOPPRA would halt at a sharp bend between two grid points of the first grid, a finer one lets the motion go on."""
    rng = np.random.default_rng(407)
    count = rng.integers(4, 8)
    vertices = np.cumsum(rng.normal(size=(count, 7)) * 0.4, axis=0)
    path = along(vertices, rng.uniform(0.02, 0.2, size=count))
    trajectory = retime(path, limits)
    speed = np.linalg.norm(trajectory.v, axis=1)
    inside = (trajectory.times > 0.1) & (trajectory.times < trajectory.duration - 0.1)
    assert speed[inside].min() > 0.02
    assert trajectory.duration < 2.8
