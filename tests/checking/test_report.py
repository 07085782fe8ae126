"""Trials add up to a verdict with its reasons."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rlbench_pin.checking.page import page, table
from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import (
    Cost,
    DemoTrial,
    FailedAttempt,
    FrictionTrial,
    KeyFramesTrial,
    NoopTrial,
    RandomTrial,
    ReachTrial,
    RepeatTrial,
    SolvedDemo,
    Trial,
    UnseenTrial,
    WordsTrial,
)
from rlbench_pin.checking.report import TaskReport, summarise
from rlbench_pin.checking.validate import NoopEpisode
from rlbench_pin.environment.demos import SegmentReport
from rlbench_pin.environment.episode import drawn_variations
from rlbench_pin.rates import Rate

SEGMENTS = (SegmentReport(0, "straight", 0.06, 2.0), SegmentReport(1, "search", 0.04, 3.0))
DEMO = SolvedDemo(
    frames=100, simulated=5.0, replayed=True, stable=True, segments=SEGMENTS,
    cost=Cost(0.5, process=0.25, planning=0.1, physics=0.125, ticks=50),
)  # fmt: skip
GOOD = DemoTrial(task="push_button", seed=0, variation=0, demo=DEMO)
STILL = NoopEpisode(penetration=0.0004, held=(), arm_speed=0.0, drift=0.0002, drifter="button/cap", success=False)
NOOP = NoopTrial(task="push_button", seed=0, variation=0, episode=STILL)
FAILED = FailedAttempt("no path: x", 2)


def _words(variation: int, *instructions: str) -> WordsTrial:
    return WordsTrial(task="push_button", seed=variation, variation=variation, instructions=instructions)


def _trials(amount: int = 20) -> list[Trial]:
    demos = [replace(GOOD, seed=i, variation=i % 3) for i in range(amount)]
    others = [NOOP, RepeatTrial(task="push_button", seed=0, variation=0)]
    return demos + others + [_words(v, f"Press button {v}.") for v in range(3)]


def _content(*reports: TaskReport) -> dict[str, object]:
    settings = {"episodes": 20, "seed": 0, "max_attempts": 10, "max_variations": 20, "versions": {"numpy": "2"}}
    return {**settings, "tasks": {r.task: r.as_dict() for r in reports}}


def test_a_good_task_passes() -> None:
    """No faults, and the figures are those of the trials."""
    report = summarise("push_button", _trials())
    assert report.faults == ()
    assert report.variations == (0, 1, 2)
    assert (report.frames, report.simulated, report.speed.times_real_time) == (100.0, 5.0, 20.0)
    line = " ".join(table([report]).splitlines()[1].split())
    figures = "20/20 84%..100% 20/20 20/20 0/0 20/20 20/20 0/0 0/0 0/1 0/0 1/1 0/0 0.20 mm 0.40 mm 5.0 s 100 ms 20.0 x"
    assert line == f"push_button 3 {figures} ok"


@pytest.mark.parametrize(
    ("worse", "fault"),
    [
        (replace(NOOP, episode=replace(STILL, success=True)), "the no-op policy succeeds"),
        (RandomTrial(task="push_button", seed=0, variation=0, reached_goal=True), "the random policy succeeds"),
        (
            RepeatTrial(task="push_button", seed=0, variation=0, differing=("reset",)),
            "a reset or a demonstration does not repeat",
        ),
        (replace(GOOD, demo=replace(DEMO, left_over=("pose of crumb",))), "an episode changes the next one"),
        (replace(NOOP, episode=replace(STILL, drift=0.0011)), "button/cap moves without actions"),
        (replace(NOOP, episode=replace(STILL, penetration=0.0021)), "objects overlap at a reset"),
        (replace(NOOP, episode=replace(STILL, held=("cup",))), "the gripper holds an object at a reset"),
        (_words(3, ""), "variation 3 lacks instructions, or repeats one"),
        (_words(3, "Go.", "Go."), "variation 3 lacks instructions, or repeats one"),
        (_words(3, "Press button 1."), "variations (1, 3) have the same instructions"),
        (ReachTrial(task="push_button", seed=0, variation=0, error="KeyError: 'cup'"), "raises an error"),
        (replace(GOOD, demo=None, failed=(FAILED,) * 10), "all attempts of a seed failed"),
    ],
)
def test_each_fault_is_named(worse: Trial, fault: str) -> None:
    """One bad trial of the hard checks is enough."""
    assert fault in summarise("push_button", [*_trials(40), worse]).faults


def test_rates_have_floors() -> None:
    """Two of twenty first tries or replays lost is too many."""
    late = [replace(GOOD, seed=100 + i, failed=(FailedAttempt("no path: after 10 checks", 1),)) for i in range(2)]
    assert summarise("push_button", [*_trials(18), *late]).faults == ("first try below 95%",)
    lost = [replace(GOOD, seed=100 + i, demo=replace(DEMO, replayed=False)) for i in range(2)]
    assert summarise("push_button", [*_trials(18), *lost]).faults == ("replay below 95%",)


def test_unseen_seeds_count_apart() -> None:
    """They have a rate and a floor of their own, and do not mend the other."""
    unseen = [UnseenTrial(task="push_button", seed=5000 + i, variation=0, demo=DEMO) for i in range(20)]
    report = summarise("push_button", [*_trials(20), *unseen])
    assert (report.unseen.count, report.unseen.of, report.first_try.of) == (20, 20, 20)
    late = [replace(trial, failed=(FailedAttempt("no path: after 10 checks", 1),)) for trial in unseen[:2]]
    report = summarise("push_button", [*_trials(20), *late, *unseen[2:]])
    assert report.faults == ("first try on unseen seeds below 95%",)
    assert report.first_try.count == 20


def test_key_frames_have_a_floor() -> None:
    """One of ten may miss the goal, two may not; seeds without a demonstration do not count."""
    good = [KeyFramesTrial(task="push_button", seed=i, variation=0, reached_goal=True) for i in range(9)]
    missed = KeyFramesTrial(task="push_button", seed=9, variation=0, reached_goal=False)
    none = KeyFramesTrial(task="push_button", seed=10, variation=0)
    report = summarise("push_button", [*_trials(20), *good, missed, none])
    assert (report.key_frames.count, report.key_frames.of, report.faults) == (9, 10, ())
    assert [failure.cause for failure in report.failures] == ["key frames: goal not reached"]
    refused = replace(missed, seed=8, refused="InvalidActionError: no path")
    report = summarise("push_button", [*_trials(20), *good[:8], missed, refused])
    assert report.faults == ("key frames below 90%",)


def test_friction_only_has_a_floor() -> None:
    """One of ten may drop its object, two may not; a task that grasps nothing is not attempted and passes."""
    good = [FrictionTrial(task="push_button", seed=i, variation=0, reached_goal=True) for i in range(9)]
    lost = (FailedAttempt("DemoError: not reached", 3),)
    dropped = FrictionTrial(task="push_button", seed=9, variation=0, reached_goal=False, failed=lost)
    report = summarise("push_button", [*_trials(20), *good, dropped])
    assert (report.friction_only.count, report.friction_only.of, report.faults) == (9, 10, ())
    assert [failure.cause for failure in report.failures] == ["friction only: DemoError: not reached"]
    report = summarise("push_button", [*_trials(20), *good[:8], dropped, replace(dropped, seed=8)])
    assert report.faults == ("friction only below 90%",)
    none = FrictionTrial(task="push_button", seed=0, variation=0)
    report = summarise("push_button", [*_trials(20), none])
    assert report.friction_only.of == 0 and report.faults == ()


def test_other_plans_in_the_same_scene_count_apart() -> None:
    """A scene that other plans solved after the first failed counts; one that none solved does not."""
    failed = replace(GOOD, failed=(FAILED,))
    trials = [
        replace(failed, seed=100, other_plans=True),
        replace(failed, seed=101, other_plans=False),
        replace(failed, seed=102),
    ]
    report = summarise("push_button", [*_trials(20), *trials])
    assert (report.same_scene.count, report.same_scene.of) == (21, 23)
    assert (report.first_try.count, report.within_tries.count) == (20, 23)


def test_flailing_may_reach_a_target() -> None:
    """The random floor of reach_target is reported, not forbidden."""
    random = RandomTrial(task="reach_target", seed=0, variation=0, reached_goal=True)
    report = summarise("reach_target", [replace(GOOD, task="reach_target"), random], by_chance=True)
    assert report.faults == ()
    assert report.random.count == 1


def test_failures_are_grouped_by_cause() -> None:
    """Causes that differ in their numbers only count together, with the first as example."""
    causes = ["no path: no path after 20 checks", "no path: no path after 31 checks", "timing: joint 3"]
    trials = [replace(GOOD, seed=i, failed=(FailedAttempt(cause, i),)) for i, cause in enumerate(causes)]
    failures = summarise("push_button", trials).failures
    assert [(f.count, f.seed, f.waypoint) for f in failures] == [(2, 0, 0), (1, 2, 2)]


def test_variations_are_drawn_without_repeats() -> None:
    """All when there are few; otherwise the same draw each time."""
    assert drawn_variations(3, 20) == (0, 1, 2)
    drawn = drawn_variations(60, 20)
    assert len(set(drawn)) == 20
    assert drawn == drawn_variations(60, 20)
    assert max(drawn) < 60


def test_variations_may_share_a_goal_when_the_task_says_so() -> None:
    """Then the same instructions are no fault."""
    same = [*_trials(), _words(3, "Press button 1.")]
    assert summarise("push_button", same, shared_goals=True).faults == ()


def test_each_variation_has_its_rates() -> None:
    """First tries and successes are counted by variation."""
    late = replace(GOOD, seed=50, variation=1, failed=(FailedAttempt("a", 0), FailedAttempt("b", 0)))
    report = summarise("push_button", [*_trials(6), late])
    assert {v: (first.count, first.of, within.count) for v, (first, within) in report.per_variation.items()} == {
        0: (2, 2, 2),
        1: (2, 3, 3),
        2: (2, 2, 2),
    }


def test_segments_and_shares_of_time_add_up() -> None:
    """By waypoint: how often it is reached, how long planning takes and the motion is; and what the whole is spent on."""
    slower = replace(
        GOOD,
        seed=99,
        failed=(FailedAttempt("a", 1), FailedAttempt("b", None)),
        demo=replace(DEMO, segments=(SegmentReport(0, "search", 0.16, 4.0),)),
    )
    report = summarise("push_button", [GOOD, slower])
    first, second = report.segments
    assert (first.waypoint, first.reached, first.methods) == (0, Rate(2, 2), {"search": 1, "straight": 1})
    assert first.planning == pytest.approx((0.11, 0.155))
    assert first.duration == pytest.approx((3.0, 3.9))
    assert (second.waypoint, second.reached) == (1, Rate(1, 2))
    assert report.speed.reason.startswith("physics 50% (2.5 ms a tick); planning 40%, 0.11 s of it at waypoint 0;")


def test_reach_is_counted_by_waypoint() -> None:
    """A place counts as kept when every waypoint is in reach and the arm free."""
    places = [
        Reach((0.1, 0.2, 0.0), (0, 2), (True, True), ((0.1, 0.2),) * 2, True),
        Reach((0.1, 0.3, 0.0), (0, 2), (True, False), ((0.1, 0.3),) * 2, True),
        Reach((0.1, 0.1, 0.0), (0, 2), (True, True), ((0.1, 0.1),) * 2, False),
    ]
    trials = [ReachTrial(task="push_button", seed=i, variation=0, reach=reach) for i, reach in enumerate(places)]
    report = summarise("push_button", [*_trials(), *trials])
    assert {w: (rate.count, rate.of) for w, rate in report.reach.items()} == {0: (3, 3), 2: (2, 3)}
    assert (report.accepted.count, report.accepted.of) == (1, 3)
    assert report.faults == ()


def test_the_page_shows_what_the_json_holds() -> None:
    """Tables of tasks, variations and segments, the slowest with the reason, and images where there are some."""
    slower = replace(DEMO, cost=replace(DEMO.cost, process=1.0, physics=0.8))
    demos = [replace(GOOD, task="stack_blocks", seed=i, variation=i % 3, demo=slower) for i in range(20)]
    slow = [*demos, *(replace(t, task="stack_blocks") for t in _trials(0))]
    content = _content(summarise("push_button", _trials()), summarise("stack_blocks", slow))
    text = page(content, {"push_button": {"sheet": "images/push_button.jpg"}})
    assert "2 of 2 pass" in text
    assert "| [`push_button`](#push_button) | 3 | 100 % (84 to 100) | 20/20 |" in text
    assert "![push_button, sheet](images/push_button.jpg)" in text
    assert "| 1 | 100 % (65 to 100) | 7/7 | Press button 1. |" in text
    assert "| 1 | 20/20 | 40 ms | 40 ms | 3.00 s | 3.00 s | search 20 |" in text
    slowest = text[text.index("## Slowest tasks") :]
    assert slowest.index("`stack_blocks`") < slowest.index("`push_button`")
    assert "physics 80%" in slowest


def test_the_page_shows_older_reports() -> None:
    """With the keys of format 2."""
    content = _content(summarise("push_button", _trials()))
    task = dict(content["tasks"]["push_button"])
    task["idle"], task["lasting"] = task.pop("noop"), task.pop("stable_success")
    assert page({**content, "tasks": {"push_button": task}}) == page(content)


def test_the_json_keeps_its_format() -> None:
    """`docs/results/demo_success.json` and its readers rely on these keys and their order."""
    failed = replace(GOOD, seed=50, failed=(FailedAttempt("no path: after 7 checks", 2),), demo=replace(DEMO, replayed=False))
    plain = summarise("push_button", [*_trials(), failed]).as_dict()
    assert list(plain) == [
        "passed", "faults", "variations", "first_try", "within_tries", "same_scene", "unseen", "stable_success", "replay",
        "key_frames", "friction_only", "noop", "random", "repeat", "tidy", "accepted", "per_variation", "drift", "penetration",
        "held",
        "left_over", "instructions", "reach", "median_frames", "median_simulated_s", "p95_simulated_s", "median_planning_s",
        "times_real_time",
        "speed", "segments", "failures", "errors",
    ]  # fmt: skip
    where = {"seed": 50, "variation": 0}
    assert plain["failures"] == [
        {"cause": "no path: after 7 checks", "count": 1, **where, "attempt": 0, "waypoint": 2, "part": "demos"},
        {"cause": "replay: goal not reached", "count": 1, **where, "attempt": 1, "waypoint": None, "part": "demos"},
    ]
    assert plain["drift"] == {"mm": 0.2, "what": "button/cap", "seed": 0, "variation": 0}


def test_a_trial_without_a_start_state_is_counted_once() -> None:
    """For a demonstration or a draw it is a failure, for the other parts an error."""
    records = [kind.without_start("push_button", 0, 0, "reset: no place") for kind in (DemoTrial, ReachTrial, NoopTrial)]
    report = summarise("push_button", records)
    assert [(failure.cause, failure.count) for failure in report.failures] == [("reset: no place", 3)]
    assert report.errors == ("reset: no place",)
    assert (report.within_tries.of, report.accepted.of, report.noop.count) == (1, 1, 0)
