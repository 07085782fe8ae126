"""Trials of running tasks, how much a check does, and where the time of a demonstration goes."""

from __future__ import annotations

import pytest

from rlbench_pin.checking import FrictionTrial, KeyFramesTrial, ReachTrial
from rlbench_pin.checking.plan import REPEATS, CheckPlan, Item
from rlbench_pin.checking.trials import Stopwatch, work
from rlbench_pin.environment.presets import low_dim_config, make_environment


@pytest.mark.simulation
def test_tasks_that_clean_up_are_laid_out_again_and_again() -> None:
    """The stains of `wipe_desk` are taken away before the world is built again."""
    trials = work(Item("wipe_desk", "reach", (0, 1), max_variations=1))
    assert [type(trial) for trial in trials] == [ReachTrial, ReachTrial]
    assert [trial.error for trial in trials] == ["", ""]


@pytest.mark.simulation
def test_key_frames_are_executed_by_poses_of_the_tip() -> None:
    """Those of a demonstration of `push_button` reach the goal."""
    trials = work(Item("push_button", "key_frames", (0, 1), max_variations=2))
    assert [trial.reached_goal for trial in trials if isinstance(trial, KeyFramesTrial)] == [True, True]


@pytest.mark.simulation
def test_friction_alone_is_tried_where_something_is_grasped() -> None:
    """A demonstration of `pick_and_lift` succeeds; `push_button` has no graspable objects and is not attempted."""
    names = ("pick_and_lift", "push_button")
    trials = [trial for name in names for trial in work(Item(name, "friction_only", (0,), max_variations=1))]
    assert [trial.reached_goal for trial in trials if isinstance(trial, FrictionTrial)] == [True, None]


@pytest.mark.simulation
def test_kinds_of_work_are_parts_of_the_whole() -> None:
    """Planning, physics and observing all take time, and together no more than there was; two demonstrations add up."""
    with make_environment(low_dim_config()) as environment:
        task = environment.get_task("reach_target")
        watch = Stopwatch()
        with watch.watching(task.runtime):
            outcome = task.try_demo(seed=0)
        assert outcome.demo is not None
        once, ticks = watch.total, watch.ticks
        assert all(seconds > 0.0 for seconds in watch.spent.values())
        assert sum(watch.spent.values()) < once
        assert ticks >= outcome.duration / task.world.control_dt
        task.try_demo(seed=0)
        assert watch.ticks == ticks
        with pytest.raises(ZeroDivisionError), watch.watching(task.runtime):
            task.try_demo(seed=0)
            raise ZeroDivisionError
        assert watch.ticks == 2 * ticks
        assert watch.total > once


def _seeds(plan: CheckPlan, at_once: int = 50) -> dict[str, list[int]]:
    seeds: dict[str, list[int]] = {}
    for item in plan.items("reach_target", at_once):
        assert len(item.seeds) <= at_once
        seeds.setdefault(item.part, []).extend(item.seeds)
    return seeds


def test_each_seed_is_tried_once_in_pieces_of_any_size() -> None:
    """However the work is cut."""
    plan = CheckPlan(
        episodes=12, seed=7, unseen=3, unseen_seed=100, placements=60, contract_seeds=9, key_frames=2, friction_only=3
    )
    expected = {
        "words": [0],
        "demos": list(range(7, 19)),
        "unseen": [100, 101, 102],
        "key_frames": [7, 8],
        "friction_only": [7, 8, 9],
        "repeat": list(range(7, 7 + REPEATS)),
        "noop": list(range(7, 16)),
        "random": list(range(7, 16)),
        "reach": list(range(7, 67)),
    }
    assert _seeds(plan) == expected
    assert _seeds(plan, 1) == expected


def test_without_the_contract_only_demonstrations_are_made() -> None:
    """And the key frames of them."""
    assert _seeds(CheckPlan(episodes=2, key_frames=1, contract=False)) == {"demos": [0, 1], "key_frames": [0]}
