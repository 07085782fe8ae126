"""Controllers follow the segments of a demonstration."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.controllers import (
    FOLLOWERS,
    PLAN,
    chosen_controllers,
    follow_demo,
    follow_segment,
    record_segments,
    summarise_segments,
    table,
)
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.errors import UnknownName


@pytest.mark.simulation
def test_every_controller_follows(reach: TaskEnvironment) -> None:
    """All reach the end of a free motion within limits and touch nothing."""
    trials = list(follow_demo(reach, 0, tuple(FOLLOWERS), most=1))
    assert [t.controller for t in trials] == [PLAN, *FOLLOWERS]
    for trial in trials[1:]:
        assert sum(trial.violations.values()) == 0, trial.controller
        assert trial.touched == (), trial.controller
        assert trial.clearance > 0.0
        assert trial.tip_errors[-1] < 0.005, trial.controller
        assert len(trial.seconds) >= len(trial.tip_errors)
    summaries = summarise_segments(trials)
    assert [s.controller for s in summaries] == [t.controller for t in trials]
    assert all(name in table(summaries) for name in FOLLOWERS)


def test_a_leg_is_followed_alike_every_time(reach: TaskEnvironment) -> None:
    """What another controller did before does not matter."""
    (segment,) = record_segments(reach, 1, most=1)
    first = follow_segment(reach.runtime, segment, "VelocityFollowing")
    follow_segment(reach.runtime, segment, "ComputedTorque")
    again = follow_segment(reach.runtime, segment, "VelocityFollowing")
    assert np.array_equal(first.tip_errors, again.tip_errors)
    assert np.array_equal(first.joint_errors, again.joint_errors)


def test_torques_are_commanded_in_every_physics_step(reach: TaskEnvironment) -> None:
    """Twelve commands per control tick, and none afterwards."""
    (segment,) = record_segments(reach, 1, most=1)
    trial = follow_segment(reach.runtime, segment, "ComputedTorque")
    assert len(trial.seconds) == 12 * len(trial.tip_errors)
    assert reach.world.on_physics == []
    assert reach.world.robot.mode == "position"


def test_unknown_controllers_are_refused() -> None:
    """The nearest name is proposed; no name means all."""
    assert chosen_controllers(()) == tuple(FOLLOWERS)
    with pytest.raises(UnknownName, match="Did you mean 'CartesianMPC'"):
        chosen_controllers(("CartesianMP",))
