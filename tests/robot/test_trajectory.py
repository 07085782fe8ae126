"""Timed joint motions."""

from __future__ import annotations

import numpy as np

from rlbench_pin.robot.trajectory import Trajectory


def parabola(count: int) -> Trajectory:
    """Q = t^2 on 0 <= t <= 2."""
    t = np.linspace(0.0, 2.0, count)[:, None]
    return Trajectory(t[:, 0], t**2, 2.0 * t, np.full_like(t, 2.0))


def test_a_parabola_is_met_exactly_between_samples() -> None:
    """Cubic Hermite interpolation reproduces constant acceleration."""
    for t in (0.0, 0.1, 0.77, 1.5, 2.0):
        q, v, a = parabola(4).sample(t)
        np.testing.assert_allclose([q[0], v[0], a[0]], [t**2, 2.0 * t, 2.0], atol=1e-12)


def test_it_holds_at_its_ends() -> None:
    """Before the start and after the end the end samples are returned, as copies."""
    trajectory = parabola(3)
    trajectory.sample(-1.0)[0][:] = 9.0
    assert trajectory.sample(-1.0)[0][0] == 0.0
    assert trajectory.sample(5.0)[0][0] == 4.0
    assert trajectory.duration == 2.0


def test_before_and_after_the_motion_the_joints_rest() -> None:
    """Velocity and acceleration are zero outside, whatever they are at the ends."""
    trajectory = parabola(4)
    for t in (-0.1, trajectory.duration + 0.1):
        _, v, a = trajectory.sample(t)
        assert not v.any()
        assert not a.any()
