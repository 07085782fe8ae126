"""The trials of `rlbench-pin check` as lines of a panel, updated after each trial."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rlbench_pin.builder.contracts import ValidationLine
from rlbench_pin.checking import Item, Part, TaskReport, Trial, summarise
from rlbench_pin.checking.plan import CheckPlan
from rlbench_pin.checking.records import DemoTrial, NoopTrial, ReachTrial, SolvedDemo
from rlbench_pin.checking.report import FIRST_TRY_FLOOR, KEY_FRAMES_FLOOR, REPLAY_FLOOR
from rlbench_pin.checking.trials import work
from rlbench_pin.checking.validate import MAX_DRIFT, MAX_PENETRATION, NOOP_TIME
from rlbench_pin.rates import Rate
from rlbench_pin.tasks import find_task

_ORDER: tuple[Part, ...] = ("words", "noop", "demos", "reach", "repeat", "random", "key_frames")
_AT_ONCE: dict[Part, int] = {"reach": 25}
"""Seeds of an item of a part; 1 for other parts."""


@dataclass(frozen=True)
class Line:
    """A line of the panel, as a function of the trials."""

    name: str
    """Name of the check in `TaskReport.passes`."""
    part: Part
    amount: Callable[[TaskReport], str]
    failures: Callable[[Trial], Iterator[str]]
    """Yields the causes that a trial of the part adds."""


def items_of(task: str, episodes: int) -> list[Item]:
    """Return the items of a validation, fast parts first; the result does not depend on the order.

    Args:
        task: Path of the task file.
        episodes: Number of demonstrations.
    """
    plan = CheckPlan(episodes=episodes, key_frames=min(episodes, CheckPlan.key_frames))
    return [item for part in _ORDER for item in plan.items(task, _AT_ONCE.get(part, 1)) if item.part == part]


def validate(
    python: Path,
    episodes: int,
    on_line: Callable[[ValidationLine], None],
    on_progress: Callable[[int, int], None],
) -> tuple[ValidationLine, ...]:
    """Do all trials and return the lines of the panel.

    Args:
        python: The task file.
        episodes: Number of demonstrations.
        on_line: Called with a line whenever it changes.
        on_progress: Called with the numbers of finished and of all trials.
    """
    items, trials, known = items_of(str(python), episodes), [], dict[str, ValidationLine]()
    task, total = find_task(str(python)), sum(len(item.seeds) for item in items)
    on_progress(0, total)
    for number, item in enumerate(items):
        trials += work(item)
        report = summarise(task.get_name(), trials, task.solved_by_chance, task.variations_share_goals)
        left = {later.part for later in items[number + 1 :]}
        for line in validation_lines(report, trials, left):
            if known.get(line.name) != line:
                known[line.name] = line
                on_line(line)
        on_progress(sum(len(done.seeds) for done in items[: number + 1]), total)
    return tuple(known.values())


def validation_lines(report: TaskReport, trials: Sequence[Trial], left: set[Part]) -> Iterator[ValidationLine]:
    """Yield the lines of the parts that have begun.

    Args:
        report: Summary of the trials.
        trials: All trials so far.
        left: Parts that are not done yet.
    """
    begun = {trial.part for trial in trials}
    for line in _LINES:
        if line.part in begun:
            found = tuple((t.seed, t.variation, cause) for t in trials if t.part == line.part for cause in line.failures(t))
            passed = None if line.part in left else report.passes(line.name)
            yield ValidationLine(line.name, passed, line.amount(report), found, MEANINGS[line.name])
    errors = tuple((trial.seed, trial.variation, trial.error) for trial in trials if trial.error)
    passed = None if left and not errors else not errors
    yield ValidationLine("errors", passed, f"{len(errors)} trials", errors, MEANINGS["errors"])


def _rate(rate: Rate) -> str:
    return f"{rate.count}/{rate.of}"


def _millimetres(length: float) -> str:
    return f"{1000 * length:.2f} mm"


MEANINGS = {
    "instructions": "Every variation has instructions of its own, and none twice.",
    "noop": "Episodes that reach the goal while the arm rests. Passes with none.",
    "drift": f"Largest motion of an object by itself in {NOOP_TIME:g} s after a reset. Passes up to {_millimetres(MAX_DRIFT)}.",
    "overlap": f"Deepest overlap of objects at a reset. Passes up to {_millimetres(MAX_PENETRATION)}.",
    "held": "Objects that the gripper holds at a reset. Passes with none.",
    "first try": f"Seeds whose first demonstration succeeds. Passes from {FIRST_TRY_FLOOR:.0%}.",
    "in tries": f"Seeds of which one of {CheckPlan.max_attempts} demonstrations succeeds. Passes with all.",
    "stable": "Demonstrations whose success still holds 1 s later with the arm at rest. Never fails.",
    "replay": f"Demonstrations whose recorded actions reach the goal again. Passes from {REPLAY_FLOOR:.0%}.",
    "left over": "What an episode changes for the next one. Passes with nothing.",
    "reach": "Layouts in which the arm reaches all waypoints. Never fails.",
    "repeat": "Seeds whose reset and demonstration repeat exactly. Passes with all.",
    "random": "Episodes that reach the goal by random actions. Passes with none, or where Solved by chance is on.",
    "key frames": f"Demonstrations whose key frames, planned one by one, reach the goal. Passes from {KEY_FRAMES_FLOOR:.0%}.",
    "errors": "Trials that raise an error. Passes with none.",
}
"""Of each line: what is measured, and when it passes."""


def _first_attempts(trial: Trial) -> Iterator[str]:
    if isinstance(trial, DemoTrial) and trial.failed:
        first = trial.failed[0]
        yield first.cause if first.waypoint is None else f"waypoint{first.waypoint}: {first.cause}"


def _all_attempts(trial: Trial) -> Iterator[str]:
    if isinstance(trial, DemoTrial) and not trial.solved:
        yield from (attempt.cause for attempt in trial.failed[-1:])


def _after(cause: str, wrong: Callable[[SolvedDemo], object]) -> Callable[[Trial], Iterator[str]]:
    """Return a function that yields a cause for a demonstration that succeeded and then showed a fault."""

    def causes(trial: Trial) -> Iterator[str]:
        if isinstance(trial, DemoTrial) and trial.demo is not None and wrong(trial.demo):
            yield cause

    return causes


def _left_over(trial: Trial) -> Iterator[str]:
    if isinstance(trial, DemoTrial) and trial.demo is not None and trial.demo.left_over:
        yield f"the next episode finds {', '.join(trial.demo.left_over)}"


def _in_noop(cause: Callable[[NoopTrial], str]) -> Callable[[Trial], Iterator[str]]:
    """Return a function that yields the cause of a trial without actions, unless it is empty."""

    def causes(trial: Trial) -> Iterator[str]:
        found = cause(trial) if isinstance(trial, NoopTrial) and trial.episode is not None else ""
        if found:
            yield found

    return causes


def _drift(trial: NoopTrial) -> str:
    assert trial.episode is not None
    too_far = trial.episode.drift > MAX_DRIFT
    return f"{trial.episode.drifter} moves {_millimetres(trial.episode.drift)} by itself" if too_far else ""


def _overlap(trial: NoopTrial) -> str:
    assert trial.episode is not None
    too_deep = trial.episode.penetration > MAX_PENETRATION
    return f"objects overlap by {_millimetres(trial.episode.penetration)} at the reset" if too_deep else ""


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


_LINES = (
    Line("instructions", "words", lambda r: f"{len(r.words)} variations", _incidents),
    Line("noop", "noop", lambda r: _rate(r.noop), _incidents),
    Line("drift", "noop", lambda r: _millimetres(r.drift.value), _in_noop(_drift)),
    Line("overlap", "noop", lambda r: _millimetres(r.penetration.value), _in_noop(_overlap)),
    Line("held", "noop", lambda r: ", ".join(r.held) or "nothing", _in_noop(_held)),
    Line("first try", "demos", lambda r: _rate(r.first_try), _first_attempts),
    Line("in tries", "demos", lambda r: _rate(r.within_tries), _all_attempts),
    Line("stable", "demos", lambda r: _rate(r.stable_success), _after("the goal is lost again", lambda demo: not demo.stable)),
    Line("replay", "demos", lambda r: _rate(r.replay), _after("goal not reached", lambda demo: demo.replayed is False)),
    Line("left over", "demos", lambda r: ", ".join(r.left_over) or "nothing", _left_over),
    Line("reach", "reach", lambda r: _rate(r.accepted), _unreached),
    Line("repeat", "repeat", lambda r: _rate(r.repeat), _incidents),
    Line("random", "random", lambda r: _rate(r.random), _incidents),
    Line("key frames", "key_frames", lambda r: _rate(r.key_frames), _incidents),
)
