"""How much a check does, by the command and by the builder."""

from __future__ import annotations

from dataclasses import asdict, fields

from rlbench_pin.checking.trials import REPEATS, CheckPlan
from rlbench_pin.cli.arguments.check import Check


def _seeds(plan: CheckPlan, at_once: int = 50) -> dict[str, list[int]]:
    seeds: dict[str, list[int]] = {}
    for item in plan.items("reach_target", at_once):
        assert len(item.seeds) <= at_once
        seeds.setdefault(item.part, []).extend(item.seeds)
    return seeds


def test_the_fields_are_the_arguments_of_the_command() -> None:
    """With the same defaults."""
    default = asdict(Check())
    assert {field.name: default[field.name] for field in fields(CheckPlan)} == asdict(CheckPlan())


def test_each_seed_is_tried_once_in_pieces_of_any_size() -> None:
    """However the work is cut."""
    plan = CheckPlan(episodes=12, seed=7, unseen=3, unseen_seed=100, placements=60, contract_seeds=9, key_frames=2)
    expected = {
        "words": [0],
        "demos": list(range(7, 19)),
        "unseen": [100, 101, 102],
        "key_frames": [7, 8],
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
