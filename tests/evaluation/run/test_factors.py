"""Evaluation with factors: the same episodes without and with each setting, by the tasks that can take it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from rlbench_pin.errors import InvalidArgument, UnknownName
from rlbench_pin.evaluation import EvaluationConfig, evaluate, plan_episodes
from rlbench_pin.evaluation.results.records import results_text
from rlbench_pin.processes import ProcessEngine

CONFIG = EvaluationConfig(
    policy="expert",
    tasks=("push_button", "close_drawer"),
    episodes=2,
    factors=("friction:2", "damping:3", "instruction_none:1"),
    policy_seed_key="key",
)


@pytest.mark.simulation
def test_every_setting_has_the_same_episodes() -> None:
    """In the order of tasks, then settings; a setting is left out where a task cannot take it."""
    items = plan_episodes(CONFIG)
    settings = {name: list(dict.fromkeys(item.factors for item in items if item.name == name)) for name in CONFIG.tasks}
    assert settings == {name: ["", *CONFIG.factors] for name in CONFIG.tasks}
    seeds = {item.factors: [(i.name, i.variation, i.seed) for i in items if i.factors == item.factors] for item in items}
    assert len(set(map(tuple, seeds.values()))) == 1
    only = plan_episodes(replace(CONFIG, tasks=("reach_target", "close_drawer"), factors=("damping:1",)))
    assert {item.name for item in only if item.factors} == {"close_drawer"}


@pytest.mark.simulation
def test_settings_that_mean_nothing_are_refused() -> None:
    """Unknown, twice, level 0, or impossible for all tasks."""
    with pytest.raises(UnknownName, match="friction"):
        replace(CONFIG, factors=("frition:1",))
    for factors in (("friction:1", "friction:1"), ("friction:0",)):
        with pytest.raises(InvalidArgument, match="different settings"):
            replace(CONFIG, factors=factors)
    with pytest.raises(InvalidArgument, match="cannot change any"):
        plan_episodes(replace(CONFIG, tasks=("reach_target",), factors=("damping:1",)))


@pytest.mark.simulation
def test_results_are_equal_for_any_number_of_workers_and_resume(tmp_path: Path) -> None:
    """To the byte; level 0 is as an evaluation without factors."""
    one = evaluate(CONFIG, tmp_path / "one.json")
    two = evaluate(CONFIG, tmp_path / "two.json", engine=ProcessEngine(2))
    assert results_text(one) == results_text(two)
    assert one.factors == CONFIG.factors and {e.factors for e in one.episodes} == {"", *CONFIG.factors}
    assert evaluate(CONFIG, tmp_path / "one.json", resume=True) == one
    plain = evaluate(replace(CONFIG, factors=()), tmp_path / "plain.json")
    assert one.of_factors("").episodes == plain.episodes
