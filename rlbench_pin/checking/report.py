"""Trials of `rlbench-pin check` -> one report per task, with a verdict and its reasons."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.checking.judge import MAX_DRIFT, MAX_PENETRATION, poor_instructions, shared_instructions
from rlbench_pin.checking.speed import LegStatistics, Speed, leg_statistics, speed_of
from rlbench_pin.checking.statistics import Rate
from rlbench_pin.checking.trials import Part, Trial, ordered

FIRST_TRY_FLOOR = 0.95
REPLAY_FLOOR = 0.95

_NUMBER = re.compile(r"-?\d+(\.\d+)?")


@dataclass(frozen=True)
class Failure:
    """A cause of failed tries, and where to see it."""

    cause: str
    count: int
    seed: int
    variation: int
    attempt: int
    waypoint: int | None
    part: Part = "demos"


@dataclass(frozen=True)
class Worst:
    """The largest of a quantity over all resets, and where to see it."""

    value: float = 0.0
    """[m]"""
    what: str = ""
    seed: int = 0
    variation: int = 0

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {"mm": round(1000 * self.value, 3), "what": self.what, "seed": self.seed, "variation": self.variation}


@dataclass(frozen=True)
class TaskReport:
    """What the trials of one task add up to."""

    task: str
    variations: tuple[int, ...]
    first_try: Rate
    within_tries: Rate
    replay: Rate
    per_variation: dict[int, tuple[Rate, Rate]]
    """Variation -> first try, within the tries."""
    idle: Rate
    """Goals reached by resting."""
    random: Rate
    """Goals reached by flailing."""
    repeat: Rate
    """Resets and demonstrations that repeat bit for bit."""
    tidy: Rate
    """Episodes that leave nothing behind in the next."""
    left_over: tuple[str, ...]
    """What the others left behind."""
    drift: Worst
    """Motion of a scene left alone."""
    penetration: Worst
    """Overlap at a reset."""
    held: tuple[str, ...]
    """What was held at a reset."""
    words: dict[int, tuple[str, ...]]
    """Variation -> instructions."""
    reach: dict[int, Rate]
    """Waypoint -> places of the task from which the arm gets there."""
    accepted: Rate
    """Places that a reset would keep."""
    failures: tuple[Failure, ...]
    errors: tuple[str, ...]
    """What the task raised."""
    frames: float
    """Median length of a demonstration [frames]."""
    simulated: float
    """Median length of a demonstration [s]."""
    simulated_p95: float
    """[s]"""
    planning: float
    """Median planning time of a demonstration [s]."""
    speed: Speed
    legs: tuple[LegStatistics, ...]
    by_chance: bool = False
    """Whether flailing may succeed now and then."""
    shared_goals: bool = False
    """Whether variations may ask for the same."""

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong, empty when the task passes."""
        return _faults(self)

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        rates = ("first_try", "within_tries", "replay", "idle", "random", "repeat", "tidy", "accepted")
        return {
            "passed": not self.faults,
            "faults": list(self.faults),
            "variations": list(self.variations),
            **{name: getattr(self, name).as_dict() for name in rates},
            "per_variation": {
                str(v): {"first_try": first.as_dict(), "within_tries": within.as_dict()}
                for v, (first, within) in self.per_variation.items()
            },
            "drift": self.drift.as_dict(),
            "penetration": self.penetration.as_dict(),
            "held": list(self.held),
            "left_over": list(self.left_over),
            "instructions": {str(v): list(sentences) for v, sentences in self.words.items()},
            "reach": {str(w): rate.as_dict() for w, rate in self.reach.items()},
            "median_frames": self.frames,
            "median_simulated_s": round(self.simulated, 2),
            "p95_simulated_s": round(self.simulated_p95, 2),
            "median_planning_s": round(self.planning, 3),
            "times_real_time": round(self.speed.times_real_time, 1),
            "speed": self.speed.as_dict(),
            "legs": [leg.as_dict() for leg in self.legs],
            "failures": [vars(failure) for failure in self.failures],
            "errors": list(self.errors),
        }


def summarise(task: str, trials: Sequence[Trial], by_chance: bool = False, shared_goals: bool = False) -> TaskReport:
    """Add up all trials of one task.

    Args:
        task: Its name.
        trials: Trials of all parts.
        by_chance: Whether flailing may succeed now and then.
        shared_goals: Whether variations may ask for the same.
    """
    trials = ordered(trials)
    demos = [t for t in trials if t.part == "demos"]
    good = [t for t in demos if t.success]
    reaches = [t.reach for t in trials if t.reach is not None]
    lengths = [t.simulated for t in good]
    return TaskReport(
        task=task,
        variations=tuple(sorted({t.variation for t in demos})),
        first_try=_first_try(demos),
        within_tries=Rate(len(good), len(demos)),
        replay=Rate(sum(bool(t.replayed) for t in good), sum(t.replayed is not None for t in good)),
        per_variation=_per_variation(demos),
        idle=_rate(trials, "idle"),
        random=_rate(trials, "random"),
        repeat=_rate(trials, "repeat"),
        tidy=Rate(sum(not t.left_over for t in good), len(good)),
        left_over=tuple(sorted({thing for t in good for thing in t.left_over})),
        drift=_worst([Worst(t.rest.drift, t.rest.drifter, t.seed, t.variation) for t in trials if t.rest]),
        penetration=_worst([Worst(t.rest.penetration, "", t.seed, t.variation) for t in trials if t.rest]),
        held=tuple(sorted({name for t in trials if t.rest for name in t.rest.held})),
        words=_words(trials),
        reach={w: _reached([r.reached[r.waypoints.index(w)] for r in reaches if w in r.waypoints]) for w in _waypoints(trials)},
        accepted=_rate(trials, "reach"),
        failures=_failures(trials),
        errors=tuple(dict.fromkeys(t.error for t in trials if t.error)),
        frames=_median([t.frames for t in good]),
        simulated=_median(lengths),
        simulated_p95=float(np.percentile(lengths, 95)) if lengths else 0.0,
        planning=_median([sum(leg.planning_time for leg in t.timings) for t in good]),
        speed=speed_of(good),
        legs=leg_statistics(good),
        by_chance=by_chance,
        shared_goals=shared_goals,
    )


def _faults(report: TaskReport) -> tuple[str, ...]:
    """Return what is wrong, empty when the task passes."""
    pairs = shared_instructions(report.words)
    poor = poor_instructions(report.words)
    checks = (
        (not report.errors, "raises an error"),
        (report.first_try.value >= FIRST_TRY_FLOOR, f"first try below {FIRST_TRY_FLOOR:.0%}"),
        (report.within_tries.count == report.within_tries.of, "a seed failed every try"),
        (report.replay.value >= REPLAY_FLOOR or not report.replay.of, f"replay below {REPLAY_FLOOR:.0%}"),
        (report.idle.count == 0, "resting succeeds"),
        (report.random.count == 0 or report.by_chance, "flailing succeeds"),
        (report.repeat.count == report.repeat.of, "a reset or a demonstration does not repeat"),
        (not report.left_over, "an episode leaves something behind"),
        (report.drift.value <= MAX_DRIFT, f"{report.drift.what} moves by itself"),
        (report.penetration.value <= MAX_PENETRATION, "things overlap at a reset"),
        (not report.held, "something is held at a reset"),
        (not poor, f"variation {poor[0] if poor else ''} lacks instructions, or repeats one"),
        (not pairs or report.shared_goals, f"variations {pairs[0] if pairs else ''} have the same instructions"),
    )
    return tuple(fault for passed, fault in checks if not passed)


def _first_try(demos: Sequence[Trial]) -> Rate:
    return Rate(sum(t.success and t.tries == 1 for t in demos), len(demos))


def _per_variation(demos: Sequence[Trial]) -> dict[int, tuple[Rate, Rate]]:
    groups: dict[int, list[Trial]] = {}
    for trial in demos:
        groups.setdefault(trial.variation, []).append(trial)
    return {v: (_first_try(g), Rate(sum(t.success for t in g), len(g))) for v, g in sorted(groups.items())}


def _words(trials: Sequence[Trial]) -> dict[int, tuple[str, ...]]:
    told = sorted((t for t in trials if t.part == "words" and not t.error), key=lambda t: t.variation)
    return {t.variation: t.words for t in told}


def _waypoints(trials: Sequence[Trial]) -> list[int]:
    return sorted({w for t in trials if t.reach is not None for w in t.reach.waypoints})


def _reached(reached: Sequence[bool]) -> Rate:
    return Rate(sum(reached), len(reached))


def _worst(found: Sequence[Worst]) -> Worst:
    return max(found, key=lambda worst: worst.value, default=Worst())


def _rate(trials: Sequence[Trial], part: Part) -> Rate:
    chosen = [t for t in trials if t.part == part]
    return Rate(sum(t.success for t in chosen), len(chosen))


def _failures(trials: Sequence[Trial]) -> tuple[Failure, ...]:
    """Group failed tries by cause, numbers left aside, most frequent first; each with its first example."""
    groups: dict[str, list[Failure]] = {}

    def add(key: str, trial: Trial, cause: str, attempt: int = 0, waypoint: int | None = None) -> None:
        groups.setdefault(key, []).append(Failure(cause, 1, trial.seed, trial.variation, attempt, waypoint, trial.part))

    for trial in trials:
        for attempt, (cause, leg) in enumerate(zip(trial.causes, trial.legs)):
            add(_NUMBER.sub("#", cause), trial, cause, attempt, leg)
        if trial.error:
            add(_NUMBER.sub("#", trial.error), trial, trial.error)
        if trial.replayed is False:
            add("replay", trial, "replay: goal not reached", trial.tries - 1)
        if trial.left_over:
            add("left over", trial, f"left over: {', '.join(trial.left_over)}", trial.tries - 1)
        if trial.success and trial.part in ("idle", "random"):
            add(trial.part, trial, f"{trial.part}: goal reached")
    chosen = sorted(groups.values(), key=len, reverse=True)
    return tuple(Failure(**{**vars(group[0]), "count": len(group)}) for group in chosen)


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else 0.0
