"""Following trajectories, with and without feedback."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control import ComputedTorque, TrajectoryFollower, VelocityFollowing
from rlbench_pin.control.following import TrajectoryTracker
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


def ramp(duration: float) -> Trajectory:
    """Q = t."""
    t = np.linspace(0.0, duration, 9)[:, None]
    return Trajectory(t[:, 0], t, np.ones_like(t), np.zeros_like(t))


def test_commands_are_given_once_per_tick() -> None:
    """The commands are the configurations at dt, 2 dt, ..., the last one exactly the end."""
    tracker = TrajectoryTracker(ramp(0.23), 0.05)
    assert len(tracker) == 5
    np.testing.assert_allclose([q[0] for q in tracker], [0.05, 0.1, 0.15, 0.2, 0.23])
    assert tracker.done
    assert len(tracker) == 0
    assert tracker.time == 0.23


def test_a_whole_number_of_ticks_gives_no_extra_one() -> None:
    """Rounding does not add a tick."""
    assert len(list(TrajectoryTracker(ramp(0.15), 0.05))) == 3


def test_the_end_is_exact_and_at_rest() -> None:
    """The last command equals the last sample bit for bit, with no velocity."""
    trajectory = ramp(0.1)
    tracker = TrajectoryTracker(trajectory, 0.05)
    next(tracker)
    q, v, _ = tracker.next_state()
    np.testing.assert_array_equal(q, trajectory.q[-1])
    np.testing.assert_array_equal(v, [0.0])


def test_standing_still_is_one_command() -> None:
    """A trajectory without duration commands its only configuration once."""
    rest = np.zeros((1, 2))
    commands = list(TrajectoryTracker(Trajectory(np.zeros(1), rest + 3.0, rest, rest), 0.05))
    np.testing.assert_array_equal(commands, [[3.0, 3.0]])


def test_a_tiny_motion_that_turns_back_has_an_end() -> None:
    """Also where every sample is near its end, but not near its start."""
    q = np.array([[0.0], [0.0051], [0.004], [0.003]])
    tracker = TrajectoryTracker(Trajectory(0.05 * np.arange(4), q, np.zeros((4, 1)), np.zeros((4, 1))), 0.05, least_speed=0.1)
    assert list(tracker)[-1] == pytest.approx([0.003])


def test_a_tick_has_a_length() -> None:
    """A tick of 0 s would never end."""
    with pytest.raises(ValueError, match="> 0"):
        TrajectoryTracker(ramp(1.0), 0.0)
