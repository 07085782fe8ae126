"""The splits: which tasks are practised, and which are held out."""

from __future__ import annotations

from collections import Counter

import pytest

from rlbench_pin.errors import InvalidValue, UnknownName
from rlbench_pin.evaluation import meta_split, meta_splits, public_tasks, task_set, task_tier
from rlbench_pin.tasks import task_names


def test_v1_holds_out_a_tenth_that_spans_the_tiers() -> None:
    """11 of the 106 tasks, of each tier about as large a share; together the splits have every task once."""
    split = meta_split("V1")
    assert sorted((*split.train, *split.test)) == sorted(public_tasks())
    assert len(split.test) == 11
    assert Counter(task_tier(task) for task in split.test) == {1: 1, 2: 3, 3: 3, 4: 4}


def test_the_few_shot_sets_are_splits() -> None:
    """With the parts that they have as sets, none in common."""
    assert meta_splits() == ("V1", "FS10_V1", "FS25_V1", "FS50_V1", "FS95_V1")
    for name in meta_splits()[1:]:
        split, parts = meta_split(name), task_set(name).parts
        assert (split.train, split.test) == (parts["train"], parts["test"])
        assert not set(split.train) & set(split.test)


def test_test_tasks_may_be_kept_to() -> None:
    """One, or all; those to train on stay."""
    split = meta_split("V1")
    assert split.chosen([]) == split
    assert split.chosen(["push_buttons"]).test == ("push_buttons",)
    assert split.chosen(["push_buttons"]).train == split.train
    assert {*split.train, *split.test} <= set(task_names())


def test_wrong_names() -> None:
    """Splits that do not exist, no names."""
    with pytest.raises(UnknownName, match="FS10_V1"):
        meta_split("FS10")
    with pytest.raises(InvalidValue):
        meta_split("V1").chosen(3)  # type: ignore[arg-type]
