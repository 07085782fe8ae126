"""Trials add up to a verdict with its reasons."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rlbench_pin.cli.check import table
from rlbench_pin.cli.report import summarise
from rlbench_pin.cli.trials import Trial, drawn_variations

GOOD = Trial("push_button", "demos", 0, 0, True, 1, replayed=True, frames=100, simulated=5.0, planning=0.1, wall=0.25)


def _trials(amount: int = 20) -> list[Trial]:
    demos = [replace(GOOD, seed=i, variation=i % 3) for i in range(amount)]
    return demos + [Trial("push_button", "idle", 0, 0, False), Trial("push_button", "repeat", 0, 0, True)]


def test_a_good_task_passes() -> None:
    """No faults, and the figures are those of the trials."""
    report = summarise("push_button", _trials())
    assert report.faults() == ()
    assert report.variations == (0, 1, 2)
    assert (report.frames, report.simulated, report.speed) == (100.0, 5.0, 20.0)
    line = " ".join(table([report]).splitlines()[1].split())
    assert line == "push_button 3 20/20 84%..100% 20/20 20/20 0/1 0/0 1/1 5.0 s 100 ms 20 x ok"


@pytest.mark.parametrize(
    ("worse", "fault"),
    [
        (replace(GOOD, part="idle"), "resting succeeds"),
        (replace(GOOD, part="random"), "flailing succeeds"),
        (replace(GOOD, part="repeat", success=False), "a reset does not repeat"),
        (replace(GOOD, success=False, tries=10, causes=("no path: x",), legs=(2,)), "a seed failed every try"),
    ],
)
def test_each_fault_is_named(worse: Trial, fault: str) -> None:
    """One bad trial of the hard checks is enough."""
    assert fault in summarise("push_button", [*_trials(40), worse]).faults()


def test_rates_have_floors() -> None:
    """Two of twenty first tries or replays lost is too many."""
    late = [replace(GOOD, seed=100 + i, tries=2, causes=("no path: after 10 checks",), legs=(1,)) for i in range(2)]
    assert summarise("push_button", [*_trials(18), *late]).faults() == ("first try below 95%",)
    lost = [replace(GOOD, seed=100 + i, replayed=False) for i in range(2)]
    assert summarise("push_button", [*_trials(18), *lost]).faults() == ("replay below 95%",)


def test_flailing_may_reach_a_target() -> None:
    """The random floor of reach_target is reported, not forbidden."""
    report = summarise(
        "reach_target", [replace(GOOD, task="reach_target"), Trial("reach_target", "random", 0, 0, True)], by_chance=True
    )
    assert report.faults() == ()
    assert report.random.count == 1


def test_failures_are_grouped_by_cause() -> None:
    """Causes that differ in their numbers only count together, with the first as example."""
    causes = [("no path: no path after 20 checks",), ("no path: no path after 31 checks",), ("timing: joint 3",)]
    trials = [replace(GOOD, seed=i, tries=2, causes=c, legs=(i,)) for i, c in enumerate(causes)]
    failures = summarise("push_button", trials).failures
    assert [(f.count, f.seed, f.waypoint) for f in failures] == [(2, 0, 0), (1, 2, 2)]


def test_variations_are_drawn_without_repeats() -> None:
    """All when there are few; otherwise the same draw each time."""
    assert drawn_variations(3, 20) == (0, 1, 2)
    drawn = drawn_variations(60, 20)
    assert len(set(drawn)) == 20
    assert drawn == drawn_variations(60, 20)
    assert max(drawn) < 60
