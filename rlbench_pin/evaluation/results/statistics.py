"""Rates of an evaluation with their intervals: per task, and in the mean over tasks by a stratified bootstrap."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.evaluation.results.records import EpisodeRecord, Results
from rlbench_pin.rates import Rate, wilson
from rlbench_pin.values import as_record, as_several, as_whole

DRAWS = 10_000
"""Resampled evaluations of a bootstrap."""
LEVEL = (0.025, 0.975)
"""Quantiles between which 95 % lie."""
FEW = 100
"""With fewer episodes of a task, tables say how wide the intervals are."""


@dataclass(frozen=True)
class Estimate:
    """A number with the interval that holds the true one in about 95 of 100 evaluations."""

    value: float
    low: float
    high: float

    def as_dict(self) -> dict[str, float | list[float]]:
        """Plain numbers for JSON."""
        return {"value": round(self.value, 4), "interval_95": [round(self.low, 4), round(self.high, 4)]}


@dataclass(frozen=True)
class TaskSummary:
    """What came of the episodes of one task."""

    task: str
    success: Rate
    held: Rate
    """Successes that were still there after the scene had come to rest."""
    steps: float | None
    """Median of the actions of successful episodes; None without any."""
    seconds: float | None
    """Median of their time in the simulation; None without any [s]."""
    refused: dict[str, int]
    """Cause -> actions that were refused for it, in all episodes."""
    collisions: int
    """In all episodes."""
    max_force: float
    """Largest force of a collision [N]."""
    violations: dict[str, int]
    """Limit -> control ticks in which it was violated, in all episodes."""
    faults: dict[str, int]
    """Kind -> episodes that a fault of the policy ended."""


@dataclass(frozen=True)
class Summary:
    """What came of an evaluation."""

    policy: str
    tasks: tuple[TaskSummary, ...]
    success: Estimate
    """Mean over tasks, each with the same weight."""
    held: Estimate
    """Likewise, of success that lasts."""
    episodes: int
    """Of all tasks together."""


def summarise(results: Results, rng: np.random.Generator) -> Summary:
    """Return what came of an evaluation.

    Args:
        results: The evaluation.
        rng: Draws the resampled evaluations of the bootstrap.
    """
    as_record(results, Results, "results")
    as_record(rng, np.random.Generator, "rng")
    by_task: dict[str, list[EpisodeRecord]] = {task: [] for task in results.tasks}
    for episode in results.episodes:
        by_task[episode.task].append(episode)
    tasks = tuple(_task_summary(task, episodes) for task, episodes in by_task.items())
    success, held = (mean_rate([getattr(task, name) for task in tasks], rng) for name in ("success", "held"))
    return Summary(results.policy, tasks, success, held, len(results.episodes))


def _task_summary(task: str, episodes: Sequence[EpisodeRecord]) -> TaskSummary:
    solved, count = [e for e in episodes if e.success], len(episodes)
    return TaskSummary(
        task=task,
        success=Rate(len(solved), count),
        held=Rate(sum(e.lasts for e in episodes), count),
        steps=statistics.median(e.steps for e in solved) if solved else None,
        seconds=statistics.median(e.seconds for e in solved) if solved else None,
        refused=_added(e.refused for e in episodes),
        collisions=sum(e.collisions for e in episodes),
        max_force=max((e.max_force for e in episodes), default=0.0),
        violations=_added(e.violations for e in episodes),
        faults=dict(sorted(Counter(e.fault for e in episodes if e.fault).items())),
    )


def mean_rate(rates: Sequence[Rate], rng: np.random.Generator, draws: int = DRAWS) -> Estimate:
    """Return the mean of the rates of tasks with a bootstrap interval in which every task is a stratum.

    Episodes are drawn again within each task, with replacement, as many as there are; the tasks stay. A task in which all
    episodes went alike has no spread of its own: there the spread is that of the rate (k + 1/2) / (n + 1).

    Args:
        rates: One per task; those of nothing tried are left out.
        rng: Draws the episodes.
        draws: How often all of them are drawn.

    Raises:
        InvalidValue: Something else than rates, or no draw.
    """
    rates = [as_record(rate, Rate, "A rate") for rate in as_several(rates, "rates")]
    as_record(rng, np.random.Generator, "rng")
    draws = as_whole(draws, "draws", least=1, most=10**7)
    tried = [rate for rate in rates if rate.of]
    if not tried:
        return Estimate(0.0, 0.0, 1.0)
    spread = np.zeros(draws)
    for rate in tried:
        p = rate.value if 0 < rate.count < rate.of else (rate.count + 0.5) / (rate.of + 1)
        spread += rng.binomial(rate.of, p, draws) / rate.of - p
    value = float(np.mean([rate.value for rate in tried]))
    low, high = np.quantile(spread / len(tried), LEVEL)
    return Estimate(value, float(np.clip(value + low, 0.0, value)), float(np.clip(value + high, value, 1.0)))


def width_note(episodes: int) -> str:
    """Return a sentence that says how much so many episodes of a task tell; empty where they are many.

    Args:
        episodes: Of each task.
    """
    episodes = as_whole(episodes, "episodes", least=0, most=10**9)
    if not 0 < episodes < FEW:
        return ""
    counts = [round(share * episodes) for share in (0.5, 0.9)]
    parts = []
    for count in counts:
        low, high = wilson(count, episodes)
        parts.append(f"at {count / episodes:.0%} of success the interval goes from {low:.0%} to {high:.0%}")
    return f"{episodes} episode{'s' if episodes > 1 else ''} of a task tell little: {', '.join(parts)}."


def _added(counts: object) -> dict[str, int]:
    """Return the sums of tables of counts, in alphabetical order."""
    total: Counter[str] = Counter()
    for table in as_several(counts, "counts"):
        total.update(table)
    return dict(sorted(total.items()))
