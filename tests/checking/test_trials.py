"""Trials of running tasks: what is left of one layout does not spoil the next, and key frames alone reach the goal."""

from __future__ import annotations

import pytest

from rlbench_pin.checking import KeyFramesTrial, ReachTrial
from rlbench_pin.checking.trials import Item, work

pytestmark = pytest.mark.simulation


def test_tasks_that_clean_up_are_laid_out_again_and_again() -> None:
    """The stains of `wipe_desk` are taken away before the world is built again."""
    trials = work(Item("wipe_desk", "reach", (0, 1), max_variations=1))
    assert [type(trial) for trial in trials] == [ReachTrial, ReachTrial]
    assert [trial.error for trial in trials] == ["", ""]


def test_key_frames_are_executed_by_poses_of_the_tip() -> None:
    """Those of a demonstration of `push_button` reach the goal."""
    trials = work(Item("push_button", "key_frames", (0, 1), max_variations=2))
    assert [trial.reached_goal for trial in trials if isinstance(trial, KeyFramesTrial)] == [True, True]
