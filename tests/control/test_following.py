"""Following a trajectory with feedback."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import ComputedTorque, TrajectoryFollower, VelocityFollowing
from rlbench_pin.errors import InvalidTarget
from rlbench_pin.robot.model import RobotModel
from rlbench_pin.robot.trajectory import Trajectory
from tests.control.analytic_worlds import simulate

START = np.array([0.0, 0.175, 0.0, -1.2, 0.0, 1.4, 0.785])


def swing(duration: float = 2.0) -> Trajectory:
    """All joints go by 0.4 rad and come to rest, as a polynomial of degree five."""
    t = np.linspace(0.0, duration, 101)
    s = (t / duration)[:, None]
    reach = 0.4 * np.ones(7)
    q = START + reach * (10 * s**3 - 15 * s**4 + 6 * s**5)
    v = reach * (30 * s**2 - 60 * s**3 + 30 * s**4) / duration
    return Trajectory(t, q, v, reach * (60 * s - 180 * s**2 + 120 * s**3) / duration**2)


def test_velocities_reproduce_the_trajectory(model: RobotModel) -> None:
    """Without disturbance the arm is on the trajectory at every tick, and ends at its end."""
    follower, q, v = TrajectoryFollower(swing(), VelocityFollowing(model.limits)), START.copy(), np.zeros(7)
    while not follower.done:
        v = follower.command(q, v)
        q = q + 0.05 * v
    assert follower.report.largest < 1e-9
    np.testing.assert_allclose(q, START + 0.4, atol=1e-9)


def test_velocities_win_back_a_lost_start(model: RobotModel) -> None:
    """Started off the trajectory, the error decays, and limits hold."""
    follower, q, v = TrajectoryFollower(swing(), VelocityFollowing(model.limits)), START + 0.1, np.zeros(7)
    while not follower.done:
        u = follower.command(q, v)
        assert np.all(np.abs(u - v) <= 0.05 * model.limits.acceleration + 1e-9)
        q, v = q + 0.05 * u, u
    assert follower.report.largest == pytest.approx(0.1)
    assert np.abs(q - START - 0.4).max() < 1e-3
    assert follower.report.rms < follower.report.largest


def test_computed_torques_cancel_the_dynamics(model: RobotModel) -> None:
    """In rigid-body dynamics the error stays below a milliradian, though the model leaves out the ticks."""
    follower, plant = TrajectoryFollower(swing(), ComputedTorque(model)), RobotModel(model.description)
    q, v = START.copy(), np.zeros(7)
    while not follower.done:
        q, v = simulate(plant, q, v, follower.command(q, v), follower.backend.dt)
    assert follower.report.largest < 2e-3
    assert follower.report.ticks == 480


def test_bad_states_are_refused(model: RobotModel) -> None:
    """NaN raises the typed error."""
    with pytest.raises(InvalidTarget):
        TrajectoryFollower(swing(), VelocityFollowing(model.limits)).command(np.full(7, np.nan), np.zeros(7))
