"""Rates, their intervals and the tests of differences are what theory and simulation say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest
from write_results_tables import PAGE, page

from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.results.statistics import (
    SIGNIFICANT,
    episodes_needed,
    holm,
    mcnemar,
    mean_rate,
    pair_shares,
    paired_power,
    summarise,
    width_note,
)
from rlbench_pin.rates import Rate
from tests.evaluation.results.made import results

FIRST, SECOND, SHARED = 0.80, 0.85, 0.8
"""Two policies that differ by 5 points; in 80 % of the episodes what is hard for the one is hard for the other."""


def test_a_summary_counts_what_happened() -> None:
    """Per task, with the median of the steps of successes, and everything else added up."""
    summary = summarise(results({"reach_target": "1101f", "open_drawer": "00000"}), np.random.default_rng(0))
    first, second = summary.tasks
    assert (first.success.count, first.success.of, first.stable.count, first.steps, first.seconds) == (3, 5, 3, 11, 1.0)
    assert (first.refused, first.collisions, first.max_force) == ({"collision": 2, "workspace": 4}, 2, 12.5)
    assert (first.violations, first.faults) == ({"velocity": 10}, {"crashed": 1})
    assert (second.success.count, second.steps, second.seconds, second.faults) == (0, None, None, {})
    assert summary.success.value == pytest.approx(0.3) and summary.episodes == 10
    assert summary.success.low < 0.3 < summary.success.high < 0.6


def test_the_bootstrap_is_seeded_and_covers() -> None:
    """Equal generators give equal intervals; the true mean is inside for about 95 of 100 evaluations, also near 0 and 1."""
    rates = [Rate(20, 25), Rate(3, 25)]
    assert mean_rate(rates, np.random.default_rng(3)) == mean_rate(rates, np.random.default_rng(3))
    rng = np.random.default_rng(0)
    for truth in (np.linspace(0.1, 0.9, 5), np.full(5, 0.97), np.array([0.4, 0.99, 0.4, 0.99, 0.4])):
        inside = 0
        for _ in range(300):
            found = mean_rate([Rate(int(k), 25) for k in rng.binomial(25, truth)], rng, 1000)
            inside += found.low <= truth.mean() <= found.high
        assert 270 <= inside <= 300


def test_intervals_of_all_and_nothing_have_a_width() -> None:
    """Twenty-five of twenty-five is not certainty, and nothing tried is anything."""
    rng = np.random.default_rng(0)
    low, high = mean_rate([Rate(0, 25)] * 3, rng), mean_rate([Rate(25, 25)] * 3, rng)
    assert low.value == low.low == 0.0 and 0.01 < low.high < 0.1
    assert high.value == high.high == 1.0 and 0.9 < high.low < 0.99
    nothing = mean_rate([Rate(0, 0)], rng)
    assert (nothing.low, nothing.high) == (0.0, 1.0)
    with pytest.raises(InvalidValue):
        mean_rate([0.5], rng)  # type: ignore[list-item]


@pytest.mark.parametrize(("first", "second"), [(0, 0), (1, 0), (5, 5), (0, 6), (5, 15), (15, 5), (200, 260), (0, 400)])
def test_mcnemar_is_the_binomial_test(first: int, second: int) -> None:
    """Of the pairs that differ; mid-p has half of the probability of what was observed on each side."""
    found, differ = mcnemar(first, second), first + second
    exact = binomtest(first, differ).pvalue if differ else 1.0
    assert found.exact == pytest.approx(exact, rel=1e-9)
    if first != second:
        one = binomtest(min(first, second), differ, alternative="less").pvalue
        below = binomtest(min(first, second) - 1, differ, alternative="less").pvalue if min(first, second) else 0.0
        assert found.mid == pytest.approx(one + below, rel=1e-9)
    assert found.mid <= found.exact


def test_holm() -> None:
    """The example of a textbook: never below the p-value before it, never above 1, in the order given."""
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.9, 0.8, 0.001, 0.001]) == pytest.approx([1.0, 1.0, 0.004, 0.004])
    assert holm([]) == []


def simulate(rng: np.random.Generator, episodes: int, first: float, second: float) -> tuple[int, int]:
    """Play paired episodes; return how often the first alone, and the second alone, succeeded.

    In a share SHARED of the episodes both policies meet the same hardness u ~ U(0, 1), in the others each its own; a policy
    succeeds where u is below its rate.
    """
    own = rng.random((2, episodes))
    own[1] = np.where(rng.random(episodes) < SHARED, own[0], own[1])
    a, b = own[0] < first, own[1] < second
    return int((a & ~b).sum()), int((b & ~a).sum())


def test_five_points_are_seen_at_400_episodes_and_not_at_25() -> None:
    """In most of 400 simulated comparisons, and in hardly any; without a difference in at most one of twenty. Theory agrees."""
    rng = np.random.default_rng(0)
    calls = {}
    for episodes, second in ((400, SECOND), (25, SECOND), (400, FIRST)):
        found = [mcnemar(*simulate(rng, episodes, FIRST, second)).exact < SIGNIFICANT for _ in range(400)]
        calls[episodes, second] = float(np.mean(found))
    assert calls[400, SECOND] > 0.8 and calls[25, SECOND] < 0.05 and calls[400, FIRST] <= 0.06
    for (episodes, second), share in calls.items():
        assert share == pytest.approx(paired_power(FIRST, second, SHARED, episodes), abs=0.05)
    assert paired_power(FIRST, SECOND, SHARED, 400) == pytest.approx(0.881, abs=1e-3)
    assert paired_power(FIRST, SECOND, SHARED, 25) == pytest.approx(0.005, abs=1e-3)


def test_how_hardness_is_shared_decides() -> None:
    """Pairs that are as hard for both differ seldom and in one way; unrelated ones often and in both."""
    assert pair_shares(0.8, 0.85, 1.0) == pytest.approx((0.0, 0.05))
    assert pair_shares(0.8, 0.85, 0.0) == pytest.approx((0.12, 0.17))
    needed = [episodes_needed(0.8, 0.85, shared) for shared in (0.0, 0.5, 0.8, 1.0)]
    assert needed == sorted(needed, reverse=True) and 300 < needed[2] < 400 < needed[1]
    assert paired_power(0.8, 0.8, 1.0, 100) == 0.0
    with pytest.raises(InvalidValue):
        episodes_needed(0.8, 0.8, 0.5)


def test_few_episodes_are_said_to_be_few() -> None:
    """With the intervals that they leave."""
    assert width_note(25).startswith("25 episodes of a task give wide intervals: at 48% success the interval is 30% to 67%")
    assert width_note(1).startswith("1 episode of")
    assert width_note(0) == width_note(100) == ""


def test_the_page_has_these_figures() -> None:
    """Its tables are those that the functions give."""
    assert PAGE.read_text(encoding="utf-8") == page(), "run `python scripts/write_results_tables.py`"
