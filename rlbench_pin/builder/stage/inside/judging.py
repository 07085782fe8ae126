"""The validator as a panel: what `rlbench-pin check` asks, judged line by line while it goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rlbench_pin.builder.contracts import Judgement
from rlbench_pin.checking import Item, Part, TaskReport, Trial, summarise
from rlbench_pin.checking.records import DemoTrial, NoopTrial, ReachTrial, SolvedDemo
from rlbench_pin.checking.report import FIRST_TRY_FLOOR, KEY_FRAMES_FLOOR, REPLAY_FLOOR
from rlbench_pin.checking.trials import CheckPlan, work
from rlbench_pin.checking.validate import MAX_DRIFT, MAX_PENETRATION, poor_instructions, shared_instructions
from rlbench_pin.rates import Rate
from rlbench_pin.tasks import find_task

_ORDER: tuple[Part, ...] = ("words", "noop", "demos", "reach", "repeat", "random", "key_frames")
_AT_ONCE: dict[Part, int] = {"reach": 25}
"""Seeds of an item, where not 1."""
Found = Iterator[tuple[int, int, str]]
"""Seed, variation and cause."""


@dataclass(frozen=True)
class Line:
    """How one line of the panel follows from the trials."""

    name: str
    part: Part
    figure: Callable[[TaskReport], str]
    passed: Callable[[TaskReport], bool]
    failures: Callable[[Trial], Iterator[str]]
    """Yields the causes that a trial of the part adds."""


def items_of(task: str, episodes: int) -> list[Item]:
    """Return the work, what is quick first; what it adds up to does not depend on the order.

    Args:
        task: Path of the task file.
        episodes: How many demonstrations.
    """
    plan = CheckPlan(episodes=episodes, key_frames=min(episodes, CheckPlan.key_frames))
    return [item for part in _ORDER for item in plan.items(task, _AT_ONCE.get(part, 1)) if item.part == part]


def judge(
    python: Path,
    episodes: int,
    on_judgement: Callable[[Judgement], None],
    on_progress: Callable[[int, int], None],
) -> tuple[Judgement, ...]:
    """Do all trials and return the lines of the panel.

    Args:
        python: The task file.
        episodes: How many demonstrations.
        on_judgement: Called with a line whenever it changes.
        on_progress: Called with the number of trials that are done and that there are.
    """
    items, trials, known = items_of(str(python), episodes), [], dict[str, Judgement]()
    task, total = find_task(str(python)), sum(len(item.seeds) for item in items)
    on_progress(0, total)
    for number, item in enumerate(items):
        trials += work(item)
        report = summarise(task.get_name(), trials, task.solved_by_chance, task.variations_share_goals)
        left = {later.part for later in items[number + 1 :]}
        for line in judgements(report, trials, left):
            if known.get(line.name) != line:
                known[line.name] = line
                on_judgement(line)
        on_progress(sum(len(done.seeds) for done in items[: number + 1]), total)
    return tuple(known.values())


def judgements(report: TaskReport, trials: Sequence[Trial], left: set[Part]) -> Iterator[Judgement]:
    """Yield the lines of the parts that were begun.

    Args:
        report: What the trials add up to.
        trials: All trials so far.
        left: Parts that are not done yet.
    """
    begun = {trial.part for trial in trials}
    for line in _LINES:
        if line.part in begun:
            found = tuple((t.seed, t.variation, cause) for t in trials if t.part == line.part for cause in line.failures(t))
            yield Judgement(line.name, None if line.part in left else line.passed(report), line.figure(report), found)
    errors = tuple((trial.seed, trial.variation, trial.error) for trial in trials if trial.error)
    yield Judgement("errors", None if left and not errors else not errors, f"{len(errors)} trials", errors)


def _rate(rate: Rate) -> str:
    return f"{rate.count}/{rate.of}"


def _first_attempts(trial: Trial) -> Iterator[str]:
    if isinstance(trial, DemoTrial) and trial.failed:
        first = trial.failed[0]
        yield first.cause if first.waypoint is None else f"waypoint{first.waypoint}: {first.cause}"


def _all_attempts(trial: Trial) -> Iterator[str]:
    if isinstance(trial, DemoTrial) and not trial.solved:
        yield from (attempt.cause for attempt in trial.failed[-1:])


def _after(cause: str, wrong: Callable[[SolvedDemo], object]) -> Callable[[Trial], Iterator[str]]:
    """Return what yields a cause for a demonstration that succeeded and then showed a fault."""

    def causes(trial: Trial) -> Iterator[str]:
        if isinstance(trial, DemoTrial) and trial.demo is not None and wrong(trial.demo):
            yield cause

    return causes


def _left_over(trial: Trial) -> Iterator[str]:
    if isinstance(trial, DemoTrial) and trial.demo is not None and trial.demo.left_over:
        yield f"the next episode finds {', '.join(trial.demo.left_over)}"


def _resting(cause: Callable[[NoopTrial], str]) -> Callable[[Trial], Iterator[str]]:
    """Return what yields a cause of a world that was left alone, unless it is empty."""

    def causes(trial: Trial) -> Iterator[str]:
        found = cause(trial) if isinstance(trial, NoopTrial) and trial.episode is not None else ""
        if found:
            yield found

    return causes


def _drift(trial: NoopTrial) -> str:
    assert trial.episode is not None
    too_far = trial.episode.drift > MAX_DRIFT
    return f"{trial.episode.drifter} moves {1000 * trial.episode.drift:.2f} mm by itself" if too_far else ""


def _overlap(trial: NoopTrial) -> str:
    assert trial.episode is not None
    too_deep = trial.episode.penetration > MAX_PENETRATION
    return f"things overlap by {1000 * trial.episode.penetration:.2f} mm at the reset" if too_deep else ""


def _held(trial: NoopTrial) -> str:
    assert trial.episode is not None
    return f"{', '.join(trial.episode.held)} is held at the reset" if trial.episode.held else ""


def _incidents(trial: Trial) -> Iterator[str]:
    yield from (incident.cause for incident in trial.incidents() if incident.cause != trial.error)


def _unreached(trial: Trial) -> Iterator[str]:
    if not isinstance(trial, ReachTrial) or trial.reachable or trial.error:
        return
    reach = trial.reach
    missed = [] if reach is None else [f"waypoint{w}" for w, got in zip(reach.waypoints, reach.reached, strict=True) if not got]
    yield trial.no_place or (f"out of reach: {', '.join(missed)}" if missed else "the arm at home touches something")


def _words_passed(report: TaskReport) -> bool:
    return not poor_instructions(report.words) and (report.shared_goals or not shared_instructions(report.words))


_LINES = (
    Line("instructions", "words", lambda r: f"{len(r.words)} variations", _words_passed, _incidents),
    Line("rest", "noop", lambda r: _rate(r.noop), lambda r: r.noop.count == 0, _incidents),
    Line("drift", "noop", lambda r: f"{1000 * r.drift.value:.2f} mm", lambda r: r.drift.value <= MAX_DRIFT, _resting(_drift)),
    Line(
        "overlap",
        "noop",
        lambda r: f"{1000 * r.penetration.value:.2f} mm",
        lambda r: r.penetration.value <= MAX_PENETRATION,
        _resting(_overlap),
    ),
    Line("held", "noop", lambda r: ", ".join(r.held) or "nothing", lambda r: not r.held, _resting(_held)),
    Line("first try", "demos", lambda r: _rate(r.first_try), lambda r: r.first_try.value >= FIRST_TRY_FLOOR, _first_attempts),
    Line(
        "in tries",
        "demos",
        lambda r: _rate(r.within_tries),
        lambda r: r.within_tries.count == r.within_tries.of,
        _all_attempts,
    ),
    Line(
        "lasts",
        "demos",
        lambda r: _rate(r.stable_success),
        lambda r: True,
        _after("the goal is lost again", lambda demo: not demo.stable),
    ),
    Line(
        "replay",
        "demos",
        lambda r: _rate(r.replay),
        lambda r: r.replay.value >= REPLAY_FLOOR or not r.replay.of,
        _after("goal not reached", lambda demo: demo.replayed is False),
    ),
    Line("left over", "demos", lambda r: ", ".join(r.left_over) or "nothing", lambda r: not r.left_over, _left_over),
    Line("reach", "reach", lambda r: _rate(r.accepted), lambda r: True, _unreached),
    Line("repeat", "repeat", lambda r: _rate(r.repeat), lambda r: r.repeat.count == r.repeat.of, _incidents),
    Line("flail", "random", lambda r: _rate(r.random), lambda r: r.random.count == 0 or r.by_chance, _incidents),
    Line(
        "keys",
        "key_frames",
        lambda r: _rate(r.key_frames),
        lambda r: r.key_frames.value >= KEY_FRAMES_FLOOR or not r.key_frames.of,
        _incidents,
    ),
)
