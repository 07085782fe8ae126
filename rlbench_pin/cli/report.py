"""Trials of `rlbench-pin check` -> one report per task, with a verdict and its reasons."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.cli.statistics import Rate
from rlbench_pin.cli.trials import Part, Trial

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


@dataclass(frozen=True)
class TaskReport:
    """What the trials of one task add up to."""

    task: str
    variations: tuple[int, ...]
    first_try: Rate
    within_tries: Rate
    replay: Rate
    idle: Rate
    """Goals reached by resting."""
    random: Rate
    """Goals reached by flailing."""
    repeat: Rate
    """Resets that repeat bit for bit."""
    by_chance: bool
    """Whether flailing may succeed now and then."""
    failures: tuple[Failure, ...]
    frames: float
    """Median length of a demonstration [frames]."""
    simulated: float
    """Median length of a demonstration [s]."""
    planning: float
    """Median planning time of a demonstration [s]."""
    speed: float
    """Simulated time over wall time of reset and demonstration, summed over demonstrations."""

    def faults(self) -> tuple[str, ...]:
        """Return what is wrong, empty when the task passes."""
        checks = (
            (self.first_try.value >= FIRST_TRY_FLOOR, f"first try below {FIRST_TRY_FLOOR:.0%}"),
            (self.within_tries.count == self.within_tries.of, "a seed failed every try"),
            (self.replay.value >= REPLAY_FLOOR or not self.replay.of, f"replay below {REPLAY_FLOOR:.0%}"),
            (self.idle.count == 0, "resting succeeds"),
            (self.random.count == 0 or self.by_chance, "flailing succeeds"),
            (self.repeat.count == self.repeat.of, "a reset does not repeat"),
        )
        return tuple(fault for passed, fault in checks if not passed)

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        rates = ("first_try", "within_tries", "replay", "idle", "random", "repeat")
        return {
            "passed": not self.faults(),
            "faults": list(self.faults()),
            "variations": list(self.variations),
            **{name: getattr(self, name).as_dict() for name in rates},
            "median_frames": self.frames,
            "median_simulated_s": round(self.simulated, 2),
            "median_planning_s": round(self.planning, 3),
            "times_real_time": round(self.speed, 1),
            "failures": [vars(failure) for failure in self.failures],
        }


def summarise(task: str, trials: Sequence[Trial], by_chance: bool = False) -> TaskReport:
    """Add up all trials of one task, in which flailing may succeed `by_chance` or never."""
    demos = [t for t in trials if t.part == "demos"]
    good = [t for t in demos if t.success]
    wall = sum(t.wall for t in good)
    return TaskReport(
        task=task,
        variations=tuple(sorted({t.variation for t in demos})),
        first_try=Rate(sum(t.success and t.tries == 1 for t in demos), len(demos)),
        within_tries=Rate(len(good), len(demos)),
        replay=Rate(sum(bool(t.replayed) for t in good), len(good)),
        idle=_rate(trials, "idle"),
        random=_rate(trials, "random"),
        repeat=_rate(trials, "repeat"),
        by_chance=by_chance,
        failures=_failures(trials),
        frames=_median([t.frames for t in good]),
        simulated=_median([t.simulated for t in good]),
        planning=_median([t.planning for t in good]),
        speed=sum(t.simulated for t in good) / wall if wall else 0.0,
    )


def _rate(trials: Sequence[Trial], part: Part) -> Rate:
    chosen = [t for t in trials if t.part == part]
    return Rate(sum(t.success for t in chosen), len(chosen))


def _failures(trials: Sequence[Trial]) -> tuple[Failure, ...]:
    """Group failed tries by cause, numbers left aside, most frequent first; each with its first example."""
    groups: dict[str, list[Failure]] = {}
    for trial in trials:
        for attempt, (cause, leg) in enumerate(zip(trial.causes, trial.legs)):
            groups.setdefault(_NUMBER.sub("#", cause), []).append(Failure(cause, 1, trial.seed, trial.variation, attempt, leg))
        if trial.replayed is False:
            groups.setdefault("replay", []).append(
                Failure("replay: goal not reached", 1, trial.seed, trial.variation, trial.tries - 1, None)
            )
        if trial.success and trial.part in ("idle", "random"):
            groups.setdefault(trial.part, []).append(
                Failure(f"{trial.part}: goal reached", 1, trial.seed, trial.variation, 0, None)
            )
    ordered = sorted(groups.values(), key=len, reverse=True)
    return tuple(Failure(**{**vars(group[0]), "count": len(group)}) for group in ordered)


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else 0.0
