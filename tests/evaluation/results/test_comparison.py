"""Two results are compared episode by episode, and only where they have the same episodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rlbench_pin.errors import IncompatibleResults, InvalidValue, UnknownName
from rlbench_pin.evaluation.results.comparison import Pairs, check_comparable, compare
from rlbench_pin.evaluation.results.records import Results
from tests.evaluation.results.made import results


def rng() -> np.random.Generator:
    """Return a new generator."""
    return np.random.default_rng(0)


def test_pairs_are_counted_per_task_and_overall() -> None:
    """With the difference as the mean over tasks, and its interval around it."""
    first = results({"reach_target": "1100" * 10, "open_drawer": "0" * 40}, "first")
    second = results({"reach_target": "1010" * 10, "open_drawer": "1" * 20 + "0" * 20}, "second")
    found = compare(first, second, rng())
    assert (found.first, found.second) == ("first", "second")
    reach, drawer = found.tasks
    assert reach.pairs == Pairs(10, 10, 10, 10) and reach.pairs.difference == 0.0 and reach.p_holm == 1.0
    assert drawer.pairs == Pairs(0, 0, 20, 20) and drawer.pairs.difference == 0.5
    assert drawer.p_holm == pytest.approx(2 * drawer.pairs.p.exact) and drawer.significant and not reach.significant
    assert found.pairs == Pairs(10, 10, 30, 30) and found.significant
    assert found.difference.value == 0.25 and found.difference.low < 0.25 < found.difference.high
    assert found.remarks == ()
    back = compare(second, first, rng())
    assert back.difference.value == -0.25 and back.pairs.p == found.pairs.p
    assert compare(first, second, rng()) == found


def test_the_same_results_do_not_differ() -> None:
    """Nothing is significant, and the interval still has a width."""
    made = results({"reach_target": "1" * 25})
    found = compare(made, made, rng())
    assert not found.significant and found.pairs.p.exact == 1.0
    assert found.difference.low < 0.0 < found.difference.high


def test_success_that_lasts_can_be_compared() -> None:
    """Instead of success."""
    first = results({"reach_target": "1" * 10})
    fallen = replace(first, episodes=tuple(replace(e, lasts=False) for e in first.episodes))
    assert compare(first, fallen, rng()).pairs.only_first == 0
    assert compare(first, fallen, rng(), measure="stable").pairs.only_first == 10
    with pytest.raises(UnknownName):
        compare(first, fallen, rng(), measure="steps")  # type: ignore[arg-type]


BASE = results({"reach_target": "1010", "open_drawer": "1111"})


@pytest.mark.parametrize(
    ("other", "says"),
    [
        (results({"reach_target": "1010", "open_box": "1111"}), "first has tasks open_drawer; only the second has tasks open_"),
        (results({"reach_target": "101010", "open_drawer": "111111"}), "only the second has seeds 2147483652, 2147483653"),
        (replace(BASE, episodes=tuple(replace(e, variation=9) for e in BASE.episodes)), r"\('reach_target', 0, 2147483648\)"),
        (replace(BASE, episodes=BASE.episodes[:-1]), r"only the first has episodes .*open_drawer"),
        (replace(BASE, limits={"max_steps": 100, "max_seconds": 60.0}), "max_steps is 200 in the first and 100 in the second"),
    ],
)  # fmt: skip
def test_incompatible_results_are_refused(other: Results, says: str) -> None:
    """With what differs, and what to do."""
    with pytest.raises(IncompatibleResults, match=says) as raised:
        compare(BASE, other, rng())
    assert raised.value.differences and "valuate both" in str(raised.value) or "no episode in common" in str(raised.value)


def test_unlike_versions_of_a_task_are_refused() -> None:
    """With the task, both versions and the next step; also where only common episodes are compared, or several are shown."""
    second = replace(BASE, policy="random", task_versions={"reach_target": 2, "open_drawer": 1})
    for common in (False, True):
        with pytest.raises(IncompatibleResults) as raised:
            compare(BASE, second, rng(), common=common)
        assert raised.value.differences == ("task 'reach_target' has version 1 in the first and 2 in the second",)
        assert "'noop' and 'random'" in str(raised.value) and "Evaluate the older version again" in str(raised.value)
    with pytest.raises(IncompatibleResults, match="'b' and 'c'"):
        check_comparable((results({"open_box": "1"}), BASE, second), ("a", "b", "c"))
    ones = replace(BASE, task_versions={"reach_target": 1, "open_drawer": 1})
    check_comparable((BASE, ones), ("a", "b"))
    assert compare(BASE, ones, rng()).pairs.of == 8


def test_what_both_have_can_be_compared() -> None:
    """When that is asked for; without anything in common not at all."""
    more = results({"reach_target": "101011", "open_box": "111111"})
    found = compare(BASE, more, rng(), common=True)
    assert [task.task for task in found.tasks] == ["reach_target"] and found.pairs.of == 4
    apart = results({"open_box": "1111"})
    with pytest.raises(IncompatibleResults, match="no episode in common"):
        compare(BASE, apart, rng(), common=True)
    empty = replace(BASE, episodes=())
    with pytest.raises(IncompatibleResults, match="no episode in common"):
        compare(empty, empty, rng(), common=True)


def test_limits_may_be_let_differ_and_are_remarked() -> None:
    """Versions and commits always are; a time limit of a clock says nothing about an episode."""
    other = replace(
        BASE, limits={**BASE.limits, "max_steps": 9, "time_limit": 1.0}, versions={**BASE.versions, "numpy": "2.1"}, commit="abc"
    )
    found = compare(BASE, other, rng(), any_limits=True)
    assert found.remarks == (
        "max_steps is 200 in the first and 9 in the second",
        "They were made with different versions: numpy 2.0 and 2.1.",
        "They were made at different commits: none and abc.",
    )
    with pytest.raises(InvalidValue):
        compare(BASE, "other.json", rng())  # type: ignore[arg-type]
