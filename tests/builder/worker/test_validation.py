"""The lines of the panel say what `rlbench-pin check` says."""

from __future__ import annotations

import pytest

from rlbench_pin.builder.worker.validation import items_of, validation_lines
from rlbench_pin.checking import TaskReport, Trial, summarise
from rlbench_pin.checking.plan import CheckPlan
from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import (
    DemoTrial,
    FailedAttempt,
    KeyFramesTrial,
    NoopTrial,
    RandomTrial,
    ReachTrial,
    RepeatTrial,
    SolvedDemo,
    WordsTrial,
)
from rlbench_pin.checking.validate import NoopEpisode

_WHO = {"task": "pick", "seed": 3, "variation": 1}
_GOOD = SolvedDemo(frames=9, simulated=1.0, replayed=True, stable=True)
_STILL = NoopEpisode(0.0, (), 0.0, 0.0, "cup", False)


def _good() -> dict[str, Trial]:
    return {
        "words": WordsTrial(**_WHO, instructions=("Pick it.",)),
        "demos": DemoTrial(**_WHO, demo=_GOOD),
        "noop": NoopTrial(**_WHO, episode=_STILL),
        "repeat": RepeatTrial(**_WHO),
        "random": RandomTrial(**_WHO),
        "reach": ReachTrial(**_WHO, reach=Reach((0.0, 0.0, 0.0), (0, 1), (True, True), ((0.0, 0.0), (0.1, 0.0)), True)),
        "key_frames": KeyFramesTrial(**_WHO, reached_goal=True),
    }


def _failed(times: int, demo: SolvedDemo | None = _GOOD) -> DemoTrial:
    return DemoTrial(**_WHO, failed=(FailedAttempt("no path", 2),) * times, demo=demo)


_WRONG: dict[str, tuple[Trial, dict[str, str]]] = {
    "words": (WordsTrial(**_WHO, instructions=("A.", "A.")), {"instructions": ""}),
    "attempt": (_failed(1), {"first try": "waypoint2: no path"}),
    "attempts": (_failed(10, None), {"first try": "waypoint2: no path", "in tries": "no path"}),
    "replay": (
        DemoTrial(**_WHO, demo=SolvedDemo(frames=9, simulated=1.0, replayed=False, stable=True)),
        {"replay": "not reached"},
    ),
    "left over": (
        DemoTrial(**_WHO, demo=SolvedDemo(frames=9, simulated=1.0, replayed=True, stable=True, left_over=("colors of cup",))),
        {"left over": "colors of cup"},
    ),
    "noop": (NoopTrial(**_WHO, episode=NoopEpisode(0.0, (), 0.0, 0.0, "", True)), {"noop": "goal reached"}),
    "drift": (NoopTrial(**_WHO, episode=NoopEpisode(0.0, (), 0.0, 0.02, "cup", False)), {"drift": "cup moves 20.00 mm"}),
    "overlap": (NoopTrial(**_WHO, episode=NoopEpisode(0.005, (), 0.0, 0.0, "", False)), {"overlap": "5.00 mm"}),
    "held": (NoopTrial(**_WHO, episode=NoopEpisode(0.0, ("cup",), 0.0, 0.0, "", False)), {"held": "cup is held"}),
    "repeat": (RepeatTrial(**_WHO, differing=("reset",)), {"repeat": "reset: not the same"}),
    "random": (RandomTrial(**_WHO, reached_goal=True), {"random": "goal reached"}),
    "key frames": (KeyFramesTrial(**_WHO, reached_goal=False, refused="no path"), {"key frames": "no path"}),
    "error": (RandomTrial(**_WHO, error="ValueError: boom"), {"errors": "boom"}),
}


def _report(trials: list[Trial]) -> TaskReport:
    return summarise("pick", trials)


def test_a_good_task_passes_every_line() -> None:
    """And each is there, with a figure and without failures."""
    trials = list(_good().values())
    lines = list(validation_lines(_report(trials), trials, set()))
    assert _report(trials).faults == ()
    assert all(line.passed is True and line.failures == () and line.figure for line in lines)
    assert {"instructions", "first try", "replay", "key frames", "noop", "random", "repeat", "reach", "drift", "overlap"} <= {
        line.name for line in lines
    }


@pytest.mark.parametrize("fault", _WRONG)
def test_a_fault_of_the_report_is_a_line_that_fails(fault: str) -> None:
    """Exactly the lines that are about it, with seed, variation and cause."""
    wrong, expected = _WRONG[fault]
    trials = list((_good() | {wrong.part: wrong}).values())
    lines = {line.name: line for line in validation_lines(_report(trials), trials, set())}
    assert {name for name, line in lines.items() if line.passed is False} == set(expected)
    assert _report(trials).faults
    for name, cause in expected.items():
        if cause:
            (failure,) = lines[name].failures
            assert failure[:2] == (3, 1)
            assert cause in failure[2]


def test_out_of_reach_is_said_and_no_fault() -> None:
    """As in the report: a reset draws another layout."""
    unreached = Reach((0.0, 0.0, 0.0), (0, 1), (True, False), ((0.0, 0.0), (0.1, 0.0)), True)
    trials = list((_good() | {"reach": ReachTrial(**_WHO, reach=unreached)}).values())
    (line,) = (line for line in validation_lines(_report(trials), trials, set()) if line.name == "reach")
    assert (line.passed, line.figure, line.failures) == (True, "0/1", ((3, 1, "out of reach: waypoint1"),))


def test_what_is_not_done_is_not_judged() -> None:
    """Its lines have a figure and no verdict; those of parts that were not begun are not there."""
    trials: list[Trial] = [_failed(1)]
    lines = {line.name: line for line in validation_lines(_report(trials), trials, {"demos", "random"})}
    assert lines["first try"].passed is None
    assert lines["first try"].figure == "0/1"
    assert "random" not in lines


def test_the_work_is_that_of_check() -> None:
    """Every trial that the command makes by default is made, and no other; only the order differs."""
    command = {(item.part, seed) for item in CheckPlan().items("pick") for seed in item.seeds}
    items = items_of("pick", CheckPlan.episodes)
    panel = [(item.part, seed) for item in items for seed in item.seeds]
    assert len(panel) == len(set(panel))
    assert set(panel) == command
    assert {
        (item.max_variations, item.max_attempts, item.first_seed, item.replays) for item in items if item.part != "words"
    } == {(CheckPlan.variations, CheckPlan.max_attempts, CheckPlan.seed, CheckPlan.replays)}


def test_few_demonstrations_have_few_key_frames() -> None:
    """Key frames are those of demonstrations that were asked for."""
    parts = [item.part for item in items_of("pick", 3)]
    assert (parts.count("demos"), parts.count("key_frames"), parts.count("noop")) == (3, 3, CheckPlan.contract_seeds)


def test_every_line_says_what_it_measures() -> None:
    """And when it passes."""
    trials = list(_good().values())
    lines = list(validation_lines(summarise("pick", trials), trials, set()))
    assert len(lines) == 15
    assert all(len(line.meaning) > 20 for line in lines)
