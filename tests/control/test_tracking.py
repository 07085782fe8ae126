"""Playing a trajectory tick by tick."""

from __future__ import annotations

import numpy as np
import pytest

from rlbench_pin.control.tracking import TrajectoryTracker
from rlbench_pin.robot.trajectory import Trajectory


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


def test_a_tick_has_a_length() -> None:
    """A tick of 0 s would never end."""
    with pytest.raises(ValueError, match="> 0"):
        TrajectoryTracker(ramp(1.0), 0.0)
