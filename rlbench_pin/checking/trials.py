"""What `rlbench-pin check` asks of a task, as work items that any process can do and that do not depend on each other."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from rlbench_pin.checking.judge import Rest, demo_repeats, flail_succeeds, left_over, replay_succeeds, reset_repeats, rest
from rlbench_pin.checking.reach import Reach, reach_of
from rlbench_pin.checking.stopwatch import Stopwatch
from rlbench_pin.environment import TaskEnvironment
from rlbench_pin.environment.demonstrate import LegReport
from rlbench_pin.environment.episode_seeds import drawn_variations
from rlbench_pin.environment.presets import low_dim_config, make_environment
from rlbench_pin.errors import BoundaryError, ResetError
from rlbench_pin.tasks import find_task

Part = Literal["words", "demos", "repeat", "idle", "random", "reach"]


@dataclass(frozen=True)
class Item:
    """A piece of work: some seeds of one part of the check of one task."""

    task: str
    """Name, or path of a task file."""
    part: Part
    seeds: tuple[int, ...]
    max_variations: int
    max_attempts: int = 10
    first_seed: int = 0
    replays: int = 1_000_000
    """Seeds, from the first on, whose demonstrations are replayed."""


@dataclass(frozen=True)
class Trial:
    """What one seed showed."""

    task: str
    part: Part
    seed: int
    variation: int
    success: bool
    """demos: within the tries; idle and random: the goal was reached (it should not be); repeat: the reset repeats exactly;
    reach: every waypoint can be reached."""
    tries: int = 1
    causes: tuple[str, ...] = ()
    """Why each failed try failed."""
    legs: tuple[int | None, ...] = ()
    """Waypoint at which each failed try failed."""
    error: str = ""
    """What the task raised, where it should not raise anything."""
    replayed: bool | None = None
    """Whether the recorded joint-position actions succeed again."""
    left_over: tuple[str, ...] = ()
    """What the episode left behind in the next one."""
    frames: int = 0
    simulated: float = 0.0
    """Length of the demonstration [s]."""
    wall: float = 0.0
    """Time that reset and demonstration took [s]."""
    process: float = 0.0
    """The same in time of the process [s]."""
    planning: float = 0.0
    """Process time that reset and demonstration spent planning [s]."""
    physics: float = 0.0
    """Process time that they spent simulating [s]."""
    observing: float = 0.0
    """Process time that they spent observing [s]."""
    ticks: int = 0
    """Control ticks that they simulated."""
    timings: tuple[LegReport, ...] = ()
    """Planning and length of each leg."""
    rest: Rest | None = None
    reach: Reach | None = None
    words: tuple[str, ...] = ()
    """Instructions."""


def work(item: Item) -> list[Trial]:
    """Do one item in an environment of its own."""
    name = find_task(item.task).get_name()
    try:
        with make_environment(low_dim_config()) as environment:
            task = environment.get_task(find_task(item.task))
            return list(_words(task) if item.part == "words" else _trials(task, item))
    except Exception as error:  # a user's task may raise anything; the report says what
        return [Trial(name, item.part, seed, 0, False, 0, error=_text(error)) for seed in item.seeds]


def _words(task: TaskEnvironment) -> Iterator[Trial]:
    def told(blank: Trial) -> Trial:
        return replace(blank, words=tuple(task.reset(seed=blank.seed, variation=blank.variation)[0]))

    for variation in range(task.variation_count()):
        yield _guarded(Trial(task.get_name(), "words", variation, variation, True), told)


def _trials(task: TaskEnvironment, item: Item) -> Iterator[Trial]:
    variations = drawn_variations(task.variation_count(), item.max_variations)

    def reach(blank: Trial) -> Trial:
        found = reach_of(task.runtime, blank.seed, blank.variation)
        return replace(blank, success=found.accepted, reach=found)

    parts: dict[str, Callable[[Trial], Trial]] = {
        "demos": lambda blank: demo_trial(task, blank, item.max_attempts, blank.seed - item.first_seed < item.replays),
        "repeat": lambda blank: _repeat(task, blank),
        "idle": lambda blank: _rest(task, blank),
        "random": lambda blank: replace(blank, success=flail_succeeds(task, blank.seed, blank.variation)),
        "reach": reach,
    }
    for seed in item.seeds:
        variation = variations[(seed - item.first_seed) % len(variations)]
        yield _guarded(Trial(task.get_name(), item.part, seed, variation, False), parts[item.part])


def _guarded(blank: Trial, judge: Callable[[Trial], Trial]) -> Trial:
    try:
        return judge(blank)
    except (ResetError, BoundaryError) as error:
        why = f"reset: {error}"
        in_demo = blank.part in ("demos", "reach")
        return replace(blank, success=False, tries=0, causes=(why,), legs=(None,), error="" if in_demo else why)
    except Exception as error:  # a user's task may raise anything; the report says what
        return replace(blank, success=False, tries=0, error=_text(error))


def _text(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def demo_trial(task: TaskEnvironment, blank: Trial, max_attempts: int, replay: bool = True) -> Trial:
    """Try to demonstrate one seed, then look at what it left behind, and perhaps replay the recorded actions."""
    causes: list[str] = []
    legs: list[int | None] = []
    for attempt in range(max_attempts):
        watch, began = Stopwatch(), time.perf_counter()
        with watch.watching(task.runtime):
            outcome = task.try_demo(seed=blank.seed, variation=blank.variation, attempt=attempt)
        wall = time.perf_counter() - began
        if outcome.demo is not None:
            remains = left_over(task, outcome.demo)
            return replace(
                blank, success=True, tries=attempt + 1, causes=tuple(causes), legs=tuple(legs),
                left_over=remains, replayed=replay_succeeds(task, outcome.demo) if replay else None, frames=len(outcome.demo),
                simulated=outcome.duration, wall=wall, process=watch.total, ticks=watch.ticks, timings=outcome.legs,
                planning=watch.spent["planning"], physics=watch.spent["physics"], observing=watch.spent["observing"],
            )  # fmt: skip
        causes.append(outcome.cause)
        legs.append(outcome.leg)
    return replace(blank, success=False, tries=max_attempts, causes=tuple(causes), legs=tuple(legs))


def _repeat(task: TaskEnvironment, blank: Trial) -> Trial:
    same = [("reset", reset_repeats), ("demonstration", demo_repeats)]
    causes = [f"{what}: not the same bytes twice" for what, repeats in same if not repeats(task, blank.seed, blank.variation)]
    return replace(blank, success=not causes, causes=tuple(causes), legs=(None,) * len(causes))


def _rest(task: TaskEnvironment, blank: Trial) -> Trial:
    found = rest(task, blank.seed, blank.variation)
    return replace(blank, success=found.success, rest=found)


def ordered(trials: Sequence[Trial]) -> list[Trial]:
    """Sort trials, so that a report does not depend on who finished first."""
    return sorted(trials, key=lambda t: (t.task, t.part, t.seed))
