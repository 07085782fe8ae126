"""Reports of a check: one per task, with a verdict and its reasons."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import (
    DemoTrial,
    FrictionTrial,
    KeyFramesTrial,
    NoopTrial,
    Part,
    RandomTrial,
    ReachTrial,
    RepeatTrial,
    SolvedDemo,
    Trial,
    UnseenTrial,
    WordsTrial,
    of_kind,
    ordered,
)
from rlbench_pin.checking.validate import MAX_DRIFT, MAX_PENETRATION, poor_instructions, shared_instructions
from rlbench_pin.environment.demos import SegmentReport
from rlbench_pin.rates import Rate
from rlbench_pin.values import as_flag, as_record, as_several, as_text

_NUMBER = re.compile(r"-?\d+(\.\d+)?")
FIRST_TRY_FLOOR = 0.95
REPLAY_FLOOR = 0.95
KEY_FRAMES_FLOOR = 0.9
FRICTION_FLOOR = 0.9
_RATES = (
    "first_try", "within_tries", "same_scene", "unseen", "stable_success", "replay", "key_frames", "friction_only", "noop",
    "random", "repeat", "tidy", "accepted",
)  # fmt: skip
"""Shares in the JSON, in its order."""


@dataclass(frozen=True)
class Failure:
    """A cause of failure, its count, and an example."""

    cause: str
    count: int
    seed: int
    variation: int
    attempt: int
    waypoint: int | None
    part: Part = "demos"


def group_failures(trials: Iterable[Trial]) -> tuple[Failure, ...]:
    """Group failures by cause, numbers ignored, most frequent first; each with its first example."""
    groups: dict[str, Failure] = {}
    for trial in trials:
        for found in trial.incidents():
            key = found.group or _NUMBER.sub("#", found.cause)
            first = Failure(found.cause, 0, trial.seed, trial.variation, found.attempt, found.waypoint, trial.part)
            group = groups.get(key, first)
            groups[key] = replace(group, count=group.count + 1)
    return tuple(sorted(groups.values(), key=lambda failure: -failure.count))


@dataclass(frozen=True)
class SegmentStatistics:
    """The segment to one waypoint, over all demonstrations that went there."""

    waypoint: int
    reached: Rate
    """Segments of successful demonstrations, out of those and the attempts that failed at the waypoint."""
    planning: tuple[float, float]
    """Median and 95th percentile of the process time [s]."""
    duration: tuple[float, float]
    """Median and 95th percentile of the length of the motion [s]."""
    methods: dict[str, int]
    """Planning method -> number of plans."""

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {
            "waypoint": self.waypoint,
            **self.reached.as_dict(),
            "planning_median_ms": round(1000 * self.planning[0], 1),
            "planning_p95_ms": round(1000 * self.planning[1], 1),
            "length_median_s": round(self.duration[0], 2),
            "length_p95_s": round(self.duration[1], 2),
            "methods": self.methods,
        }


@dataclass(frozen=True)
class Speed:
    """Time that resets and demonstrations of a task take."""

    times_real_time: float = 0.0
    """Median of simulated time over process time."""
    times_real_time_wall: float = 0.0
    """Median of simulated time over wall time; lower on a machine with other load."""
    planning: float = 0.0
    """Share of the process time."""
    physics: float = 0.0
    """Share of the process time."""
    observing: float = 0.0
    """Share of the process time."""
    tick: float = 0.0
    """Process time of the physics of one control tick [s]."""
    slowest_segment: int | None = None
    """Waypoint whose segments have the largest total planning time."""
    slowest_segment_planning: float = 0.0
    """Mean planning time per demonstration for segments to that waypoint [s]."""

    @property
    def other(self) -> float:
        """Share of the process time of everything else."""
        return max(0.0, 1.0 - self.planning - self.physics - self.observing)

    @property
    def reason(self) -> str:
        """The shares of the process time as text, the largest first."""
        segment = (
            ""
            if self.slowest_segment is None
            else f", {self.slowest_segment_planning:.2f} s of it at waypoint {self.slowest_segment}"
        )
        parts = [
            (self.physics, f"physics {self.physics:.0%} ({1000 * self.tick:.1f} ms a tick)"),
            (self.planning, f"planning {self.planning:.0%}{segment}"),
            (self.observing, f"observing {self.observing:.0%}"),
            (self.other, f"saving, restoring and the rest {self.other:.0%}"),
        ]
        return "; ".join(text for _, text in sorted(parts, key=lambda part: -part[0]))

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {
            "times_real_time": round(self.times_real_time, 2),
            "times_real_time_wall": round(self.times_real_time_wall, 2),
            "planning_share": round(self.planning, 3),
            "physics_share": round(self.physics, 3),
            "observing_share": round(self.observing, 3),
            "physics_tick_ms": round(1000 * self.tick, 2),
            "reason": self.reason,
        }


def speed_of(demos: Sequence[SolvedDemo]) -> Speed:
    """Return the times of successful demonstrations, each with its reset."""
    costs = [demo.cost for demo in demos]
    total, ticks = sum(c.process for c in costs), sum(c.ticks for c in costs)
    if not total:
        return Speed()
    spent: dict[int, float] = {}
    for segment in (segment for demo in demos for segment in demo.segments):
        spent[segment.waypoint] = spent.get(segment.waypoint, 0.0) + segment.planning_time
    slowest = max(spent, key=spent.__getitem__, default=None)
    on_the_wall = [demo.simulated / demo.cost.wall for demo in demos if demo.cost.wall]
    return Speed(
        times_real_time=float(np.median([demo.simulated / demo.cost.process for demo in demos if demo.cost.process])),
        times_real_time_wall=float(np.median(on_the_wall)) if on_the_wall else 0.0,
        planning=sum(c.planning for c in costs) / total,
        physics=sum(c.physics for c in costs) / total,
        observing=sum(c.observing for c in costs) / total,
        tick=sum(c.physics for c in costs) / ticks if ticks else 0.0,
        slowest_segment=slowest,
        slowest_segment_planning=0.0 if slowest is None else spent[slowest] / len(demos),
    )


def segment_statistics(trials: Sequence[DemoTrial]) -> tuple[SegmentStatistics, ...]:
    """Group the segments of successful demonstrations by waypoint; repetitions of a waypoint are one group."""
    missed = Counter(failed.waypoint for trial in trials for failed in trial.failed)
    groups: dict[int, list[SegmentReport]] = {}
    for segment in (segment for trial in trials if trial.demo for segment in trial.demo.segments):
        groups.setdefault(segment.waypoint, []).append(segment)
    return tuple(
        SegmentStatistics(
            waypoint,
            Rate(len(segments), len(segments) + missed[waypoint]),
            _spread([segment.planning_time for segment in segments]),
            _spread([segment.duration for segment in segments]),
            dict(sorted(Counter(segment.method for segment in segments).items())),
        )
        for waypoint, segments in sorted(groups.items())
    )


def _spread(values: Sequence[float]) -> tuple[float, float]:
    return float(np.median(values)), float(np.percentile(values, 95))


@dataclass(frozen=True)
class Worst:
    """The largest value of a quantity over all resets, and an example."""

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
    """Summary of the trials of one task."""

    task: str
    variations: tuple[int, ...]
    first_try: Rate
    within_tries: Rate
    """Seeds that were solved within the allowed attempts; each attempt draws the scene again."""
    same_scene: Rate
    """Seeds whose first scene was solved. After a failure, the same scene is planned again with other random draws."""
    unseen: Rate
    """First attempts on the unseen seeds."""
    stable_success: Rate
    """Successful demonstrations whose success still held after 1 s."""
    replay: Rate
    key_frames: Rate
    """Demonstrations whose key frames alone, planned again, reach the goal."""
    friction_only: Rate
    """First attempts of demonstrations in which friction alone holds grasped objects; none for tasks without grasps."""
    per_variation: dict[int, tuple[Rate, Rate]]
    """Variation -> success in the first attempt, and within all attempts."""
    noop: Rate
    """Goals reached by the no-op policy."""
    random: Rate
    """Goals reached by random actions."""
    repeat: Rate
    """Resets and demonstrations whose repetition is byte-identical."""
    tidy: Rate
    """Episodes that cause no difference in the next episode."""
    left_over: tuple[str, ...]
    """Differences that the other episodes caused."""
    drift: Worst
    """Largest motion of an object without actions."""
    penetration: Worst
    """Largest overlap of objects at a reset."""
    held: tuple[str, ...]
    """Objects that the gripper held at a reset, which is a fault."""
    words: dict[int, tuple[str, ...]]
    """Variation -> instructions."""
    reach: dict[int, Rate]
    """Waypoint -> places of the task at which the arm reaches it."""
    accepted: Rate
    """Places that a reset would accept."""
    failures: tuple[Failure, ...]
    errors: tuple[str, ...]
    """Errors of the task."""
    frames: float
    """Median length of a demonstration [frames]."""
    simulated: float
    """Median length of a demonstration [s]."""
    simulated_p95: float
    """[s]"""
    planning: float
    """Median planning time of a demonstration [s]."""
    speed: Speed
    segments: tuple[SegmentStatistics, ...]
    by_chance: bool = False
    """Whether random actions may succeed occasionally."""
    shared_goals: bool = False
    """Whether several variations may have the same goal."""

    @property
    def faults(self) -> tuple[str, ...]:
        """The faults, empty when the task passes."""
        return tuple(fault for _, passed, fault in _checks(self) if not passed)

    def passes(self, check: str) -> bool:
        """Return whether the task passes one check, such as `first try`."""
        return all(passed for name, passed, _ in _checks(self) if name == check)

    def as_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {
            "passed": not self.faults,
            "faults": list(self.faults),
            "variations": list(self.variations),
            **{name: getattr(self, name).as_dict() for name in _RATES},
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
            "segments": [segment.as_dict() for segment in self.segments],
            "failures": [vars(failure) for failure in self.failures],
            "errors": list(self.errors),
        }


def summarise(task: str, trials: Sequence[Trial], by_chance: bool = False, shared_goals: bool = False) -> TaskReport:
    """Return the report of all trials of one task.

    Args:
        task: Task name.
        trials: Trials of all parts of the check.
        by_chance: Whether random actions may succeed occasionally.
        shared_goals: Whether several variations may have the same goal.
    """
    task, by_chance = as_text(task, "task"), as_flag(by_chance, "by_chance")
    shared_goals = as_flag(shared_goals, "shared_goals")
    for trial in as_several(trials, "trials"):
        as_record(trial, Trial, "A trial")
    trials = ordered(trials)
    return TaskReport(
        task=task,
        **_of_demos(of_kind(trials, DemoTrial)),
        unseen=_first_try(of_kind(trials, UnseenTrial)),
        **_of_contract(trials),
        failures=group_failures(trials),
        errors=tuple(dict.fromkeys(trial.error for trial in trials if trial.error)),
        by_chance=by_chance,
        shared_goals=shared_goals,
    )


def _of_demos(trials: Sequence[DemoTrial]) -> dict[str, Any]:
    """Return the fields of a report that follow from demonstrations."""
    demos = [trial.demo for trial in trials if trial.demo is not None]
    lengths = [demo.simulated for demo in demos]
    return {
        "variations": tuple(sorted({trial.variation for trial in trials})),
        "first_try": _first_try(trials),
        "within_tries": _within_tries(trials),
        "same_scene": _rate([trial.solved_in_first_scene for trial in trials]),
        "stable_success": _rate([demo.stable for demo in demos]),
        "replay": _rate([demo.replayed for demo in demos if demo.replayed is not None]),
        "per_variation": _per_variation(trials),
        "tidy": _rate([not demo.left_over for demo in demos]),
        "left_over": tuple(sorted({name for demo in demos for name in demo.left_over})),
        "frames": _median([demo.frames for demo in demos]),
        "simulated": _median(lengths),
        "simulated_p95": float(np.percentile(lengths, 95)) if lengths else 0.0,
        "planning": _median([sum(segment.planning_time for segment in demo.segments) for demo in demos]),
        "speed": speed_of(demos),
        "segments": segment_statistics(trials),
    }


def _of_contract(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return the fields of a report that follow from the other parts."""
    noops, reaches = of_kind(trials, NoopTrial), of_kind(trials, ReachTrial)
    episodes = [(trial, trial.episode) for trial in noops if trial.episode is not None]
    return {
        "key_frames": _rate([trial.reached_goal for trial in of_kind(trials, KeyFramesTrial) if trial.reached_goal is not None]),
        "friction_only": _rate(
            [trial.reached_goal for trial in of_kind(trials, FrictionTrial) if trial.reached_goal is not None]
        ),
        "noop": _rate([trial.reached_goal for trial in noops]),
        "random": _rate([trial.reached_goal for trial in of_kind(trials, RandomTrial)]),
        "repeat": _rate([trial.repeats for trial in of_kind(trials, RepeatTrial)]),
        "drift": _worst([Worst(e.drift, e.drifter, trial.seed, trial.variation) for trial, e in episodes]),
        "penetration": _worst([Worst(e.penetration, "", trial.seed, trial.variation) for trial, e in episodes]),
        "held": tuple(sorted({name for _, e in episodes for name in e.held})),
        "words": _words(of_kind(trials, WordsTrial)),
        "reach": _reached([trial.reach for trial in reaches if trial.reach is not None]),
        "accepted": _rate([trial.reachable for trial in reaches]),
    }


def _checks(report: TaskReport) -> tuple[tuple[str, bool, str], ...]:
    """Return name, result and fault of each check."""
    pairs = shared_instructions(report.words)
    poor = poor_instructions(report.words)
    keys = report.key_frames.value >= KEY_FRAMES_FLOOR or not report.key_frames.of
    friction = report.friction_only.value >= FRICTION_FLOOR or not report.friction_only.of
    unseen = report.unseen.value >= FIRST_TRY_FLOOR or not report.unseen.of
    return (
        ("errors", not report.errors, "raises an error"),
        ("first try", report.first_try.value >= FIRST_TRY_FLOOR, f"first try below {FIRST_TRY_FLOOR:.0%}"),
        ("unseen", unseen, f"first try on unseen seeds below {FIRST_TRY_FLOOR:.0%}"),
        ("in tries", report.within_tries.count == report.within_tries.of, "all attempts of a seed failed"),
        ("replay", report.replay.value >= REPLAY_FLOOR or not report.replay.of, f"replay below {REPLAY_FLOOR:.0%}"),
        ("key frames", keys, f"key frames below {KEY_FRAMES_FLOOR:.0%}"),
        ("friction only", friction, f"friction only below {FRICTION_FLOOR:.0%}"),
        ("noop", report.noop.count == 0, "the no-op policy succeeds"),
        ("random", report.random.count == 0 or report.by_chance, "the random policy succeeds"),
        ("repeat", report.repeat.count == report.repeat.of, "a reset or a demonstration does not repeat"),
        ("left over", not report.left_over, "an episode changes the next one"),
        ("drift", report.drift.value <= MAX_DRIFT, f"{report.drift.what} moves without actions"),
        ("overlap", report.penetration.value <= MAX_PENETRATION, "objects overlap at a reset"),
        ("held", not report.held, "the gripper holds an object at a reset"),
        ("instructions", not poor, f"variation {poor[0] if poor else ''} lacks instructions, or repeats one"),
        ("instructions", not pairs or report.shared_goals, f"variations {pairs[0] if pairs else ''} have the same instructions"),
    )


def _rate(successes: Sequence[bool]) -> Rate:
    return Rate(sum(successes), len(successes))


def _first_try(trials: Sequence[DemoTrial]) -> Rate:
    return _rate([trial.solved_at_first for trial in trials])


def _within_tries(trials: Sequence[DemoTrial]) -> Rate:
    return _rate([trial.solved for trial in trials])


def _per_variation(trials: Sequence[DemoTrial]) -> dict[int, tuple[Rate, Rate]]:
    groups: dict[int, list[DemoTrial]] = {}
    for trial in trials:
        groups.setdefault(trial.variation, []).append(trial)
    return {variation: (_first_try(group), _within_tries(group)) for variation, group in sorted(groups.items())}


def _words(trials: Sequence[WordsTrial]) -> dict[int, tuple[str, ...]]:
    known = sorted((trial for trial in trials if not trial.error), key=lambda trial: trial.variation)
    return {trial.variation: trial.instructions for trial in known}


def _reached(reaches: Sequence[Reach]) -> dict[int, Rate]:
    """Return waypoint -> places from which the arm reaches it."""
    found: dict[int, list[bool]] = {}
    for reach in reaches:
        for waypoint, reached in zip(reach.waypoints, reach.reached, strict=True):
            found.setdefault(waypoint, []).append(reached)
    return {waypoint: _rate(found[waypoint]) for waypoint in sorted(found)}


def _worst(found: Sequence[Worst]) -> Worst:
    return max(found, key=lambda worst: worst.value, default=Worst())


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else 0.0
