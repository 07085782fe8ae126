"""What is evaluated: episodes spread over variations, from seeds that nothing else draws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rlbench_pin.environment.episode import EpisodeRandom, checked_seed
from rlbench_pin.errors import InvalidArgument, InvalidValue, RlbenchPinError, UnknownName
from rlbench_pin.evaluation.run import EVALUATION_SEEDS, EvaluationConfig, evaluation_seed, plan_episodes
from rlbench_pin.evaluation.run.config import LARGEST_START, MAX_EPISODES, policy_seed
from rlbench_pin.recording.config import item_seed

CONFIG = EvaluationConfig(policy="noop", tasks=("reach_target",))


def test_no_recording_and_no_reset_has_a_seed_of_an_evaluation() -> None:
    """Recordings make theirs below 2^53 and resets draw below 2^31, whatever they are given; evaluations begin there."""
    assert EVALUATION_SEEDS == 2**53
    assert max(item_seed(seed, "reach_target", v, i) for seed in (0, 2**63 - 1) for v in range(20) for i in range(50)) < 2**53
    assert evaluation_seed(0, 0) == 2**53
    assert evaluation_seed(3, 4) == evaluation_seed(0, 7)


def test_seeds_are_kept_by_readers_of_every_language_and_start_episodes() -> None:
    """The first and the last that there can be are equal as floating point numbers, and seeds of different episodes."""
    last = evaluation_seed(LARGEST_START, MAX_EPISODES)
    for seed in (evaluation_seed(0, 1), evaluation_seed(0, 24), last):
        assert int(float(seed)) == seed
        assert checked_seed(seed) == seed
    draws = {EpisodeRandom.from_seed(evaluation_seed(0, i)).placement.integers(2**63) for i in range(100)}
    assert len(draws) == 100


def test_policies_are_told_another_seed() -> None:
    """It is a hash: different for each episode and each key, the same each time, below 2^53, and no seed of the episode."""
    told = [policy_seed(key, 0, task, i) for key in ("k", "l") for task in ("reach_target", "push_button") for i in range(50)]
    assert len(set(told)) == 200
    assert told[100:] == [policy_seed("l", 0, task, i) for task in ("reach_target", "push_button") for i in range(50)]
    assert max(told) < 2**53
    assert np.corrcoef(told[:50], range(50))[0, 1] < 0.5


def test_a_policy_cannot_compute_what_it_is_told() -> None:
    """The key is drawn for each plan, unless one is given."""
    first, second = ([item.policy_seed for item in plan_episodes(CONFIG)] for _ in range(2))
    assert not set(first) & set(second)
    given = replace(CONFIG, policy_seed_key="abc")
    assert plan_episodes(given) == plan_episodes(given)
    for wrong in ("x" * 65, "a\nb", 5):
        with pytest.raises(InvalidArgument, match="policy_seed_key"):
            replace(CONFIG, policy_seed_key=wrong)  # type: ignore[arg-type]


def test_episodes_are_spread_evenly() -> None:
    """Fewer episodes than variations have each another one; more have each equally often; all tasks have the same seeds."""
    few = plan_episodes(replace(CONFIG, episodes=6))
    assert len({item.variation for item in few}) == 6
    many = plan_episodes(replace(CONFIG, tasks=("reach_target", "push_button"), episodes=9, variations=3))
    for task in ("reach_target", "push_button"):
        mine = [item for item in many if item.name == task]
        counts = np.unique([item.variation for item in mine], return_counts=True)[1]
        assert counts.tolist() == [3, 3, 3]
        assert [item.seed for item in mine] == [evaluation_seed(0, i) for i in range(9)]
        assert [item.index for item in mine] == list(range(9))
    assert len({item.policy_seed for item in many}) == 18


@pytest.mark.parametrize(
    "change",
    [
        {"episodes": 0}, {"episodes": 1.5}, {"seed": -1}, {"seed": 2**60}, {"max_steps": 0}, {"max_seconds": 0.0},
        {"max_seconds": float("nan")}, {"variations": 0}, {"variations": -2}, {"time_limit": -1.0}, {"robot": "pandda"},
        {"tasks": ()}, {"tasks": "reach_target"}, {"policy": ""}, {"policy": 3}, {"tell_task": "yes"}, {"task_set": None},
    ],
)  # fmt: skip
def test_wrong_settings_are_refused(change: dict[str, object]) -> None:
    """By an error of ours that names what is wrong."""
    with pytest.raises((InvalidValue, RlbenchPinError), match="."):
        replace(CONFIG, **change)  # type: ignore[arg-type]


def test_unknown_tasks_and_the_same_task_twice_are_refused() -> None:
    """Before anything is played."""
    with pytest.raises(UnknownName, match="Did you mean 'reach_target'"):
        plan_episodes(replace(CONFIG, tasks=("reach_targt",)))
    with pytest.raises(InvalidValue, match="different names"):
        plan_episodes(replace(CONFIG, tasks=("reach_target", "ReachTarget")))
