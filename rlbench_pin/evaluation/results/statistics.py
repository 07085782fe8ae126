"""Statistics of evaluations: rates with intervals, stratified bootstrap over tasks, McNemar's test, Holm's correction."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.results.records import WORKER_DIED, EpisodeRecord, Results
from rlbench_pin.rates import Rate, wilson
from rlbench_pin.spatial import FloatArray
from rlbench_pin.values import as_array, as_number, as_record, as_several, as_whole

DRAWS = 10_000
"""Resampled evaluations of a bootstrap."""
LEVEL = (0.025, 0.975)
"""Lower and upper quantile of a 95 % interval."""
FEW = 100
"""With fewer episodes of a task, tables have a note about the width of the intervals."""


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % confidence interval."""

    value: float
    low: float
    high: float

    def as_dict(self) -> dict[str, float | list[float]]:
        """Return plain numbers for JSON."""
        return {"value": round(self.value, 4), "interval_95": [round(self.low, 4), round(self.high, 4)]}


@dataclass(frozen=True)
class TaskSummary:
    """Statistics of the episodes of one task."""

    task: str
    success: Rate
    stable: Rate
    """Rate of stable success."""
    steps: float | None
    """Median number of actions of successful episodes; None without successes."""
    seconds: float | None
    """Median simulated time of successful episodes [s]; None without successes."""
    refused: dict[str, int]
    """Cause -> number of actions that were refused for it, in all episodes."""
    collisions: int
    """Number of collisions in all episodes."""
    max_force: float
    """Largest force of a collision [N]."""
    violations: dict[str, int]
    """Limit -> number of control ticks in which it was violated, in all episodes."""
    faults: dict[str, int]
    """Kind -> number of episodes that a fault of the policy ended."""
    worker_deaths: int
    """Number of workers that died in its episodes."""
    retried: int
    """Number of episodes that were played again after a worker had died."""


@dataclass(frozen=True)
class Summary:
    """Statistics of an evaluation."""

    policy: str
    tasks: tuple[TaskSummary, ...]
    success: Estimate
    """Mean over tasks, each with the same weight."""
    stable: Estimate
    """Mean of stable success over tasks, each with the same weight."""
    episodes: int
    """Number of episodes of all tasks."""
    first_faults: tuple[EpisodeRecord, ...] = ()
    """The first episode that ended with a fault, for each kind of fault."""


def summarise(results: Results, rng: np.random.Generator) -> Summary:
    """Return the statistics of an evaluation.

    Args:
        results: Results of the evaluation.
        rng: Random generator of the bootstrap.
    """
    as_record(results, Results, "results")
    as_record(rng, np.random.Generator, "rng")
    by_task: dict[str, list[EpisodeRecord]] = {task: [] for task in results.tasks}
    for episode in results.episodes:
        by_task[episode.task].append(episode)
    tasks = tuple(_task_summary(task, episodes) for task, episodes in by_task.items())
    success, stable = (mean_rate([getattr(task, name) for task in tasks], rng) for name in ("success", "stable"))
    first_faults: dict[str, EpisodeRecord] = {}
    for episode in results.episodes:
        if episode.fault:
            first_faults.setdefault(episode.fault, episode)
    return Summary(results.policy, tasks, success, stable, len(results.episodes), tuple(first_faults.values()))


def _task_summary(task: str, episodes: Sequence[EpisodeRecord]) -> TaskSummary:
    solved, count = [e for e in episodes if e.success], len(episodes)
    return TaskSummary(
        task=task,
        success=Rate(len(solved), count),
        stable=Rate(sum(e.lasts for e in episodes), count),
        steps=statistics.median(e.steps for e in solved) if solved else None,
        seconds=statistics.median(e.seconds for e in solved) if solved else None,
        refused=added_counts(e.refused for e in episodes),
        collisions=sum(e.collisions for e in episodes),
        max_force=max((e.max_force for e in episodes), default=0.0),
        violations=added_counts(e.violations for e in episodes),
        faults=dict(sorted(Counter(e.fault for e in episodes if e.fault).items())),
        worker_deaths=sum(e.worker_deaths for e in episodes),
        retried=sum(e.worker_deaths > 0 and e.fault != WORKER_DIED for e in episodes),
    )


def mean_rate(rates: Sequence[Rate], rng: np.random.Generator, draws: int = DRAWS) -> Estimate:
    """Return the mean of the rates of tasks with a bootstrap interval in which every task is a stratum.

    The bootstrap resamples the episodes of each task with replacement, with the same number of episodes; it does not resample
    tasks. A task with only successes or only failures has no spread; the spread of the rate (k + 1/2) / (n + 1) is used for it.

    Args:
        rates: Success rates, one per task; rates without episodes are left out.
        rng: Random generator of the bootstrap.
        draws: Number of resampled evaluations.

    Raises:
        InvalidValue: `rates` contains other objects, or `draws` is below 1.
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
    """Return a note about wide intervals if a task has few episodes; empty otherwise.

    Args:
        episodes: Number of episodes of each task.
    """
    episodes = as_whole(episodes, "episodes", least=0, most=10**9)
    if not 0 < episodes < FEW:
        return ""
    counts = [round(share * episodes) for share in (0.5, 0.9)]
    parts = []
    for count in counts:
        low, high = wilson(count, episodes)
        parts.append(f"at {count / episodes:.0%} success the interval is {low:.0%} to {high:.0%}")
    return f"{episodes} episode{'s' if episodes > 1 else ''} of a task give wide intervals: {', '.join(parts)}."


def added_counts(counts: object) -> dict[str, int]:
    """Return the sums of tables of counts, in alphabetical order."""
    total: Counter[str] = Counter()
    for table in as_several(counts, "counts"):
        total.update(table)
    return dict(sorted(total.items()))


# Paired outcomes --------------------------------------------------------------------------------------------------------------


SIGNIFICANT = 0.05
"""A difference with a p-value below this is significant."""
_MAX_COUNT = 10**6


@dataclass(frozen=True)
class PValues:
    """Two-sided p-values of McNemar's test, under the hypothesis that both policies are equally good."""

    exact: float
    """p-value of the exact binomial test; its error rate is at most the level."""
    mid: float
    """Mid-p value, with half the probability of the observed split; its error rate is near the level, but can exceed it."""


def mcnemar(only_first: int, only_second: int) -> PValues:
    """Return the p-values of McNemar's test for paired outcomes.

    The hypothesis is that in a pair with different outcomes, each policy succeeds with probability 1/2. With n such pairs,
    X ~ Binomial(n, 1/2) and m the smaller count: exact = 2 P(X <= m), at most 1; mid = 2 P(X < m) + P(X = m).

    Args:
        only_first: Number of pairs in which only the first succeeded.
        only_second: Number of pairs in which only the second succeeded.
    """
    first, second = (
        as_whole(value, what, least=0, most=_MAX_COUNT)
        for value, what in ((only_first, "only_first"), (only_second, "only_second"))
    )
    probabilities = _binomial(first + second, 0.5)
    low = min(first, second)
    below, here = float(probabilities[:low].sum()), float(probabilities[low])
    return PValues(min(1.0, 2.0 * (below + here)), min(1.0, 2.0 * below + here))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values with Holm's correction, in the same order: of m, the i-th smallest times m - i + 1, never decreasing.

    The probability of any false significant result among the tests is then at most the level.

    Args:
        p_values: p-values of the tests.
    """
    array = as_array(p_values, "p_values")
    if array.ndim != 1:
        raise InvalidValue("p_values", p_values, "has to be a list of numbers")
    values = [as_number(float(p), "p-value", least=0.0, most=1.0) for p in array]
    corrected, largest = [0.0] * len(values), 0.0
    for rank, place in enumerate(sorted(range(len(values)), key=values.__getitem__)):
        largest = max(largest, min(1.0, (len(values) - rank) * values[place]))
        corrected[place] = largest
    return corrected


def pair_shares(first: float, second: float, shared: float) -> tuple[float, float]:
    """Return the probabilities that only the first, and only the second policy succeeds in an episode.

    In a share of the episodes, both policies depend on a common draw u ~ U(0, 1): each succeeds if u is below its rate. The worse
    policy then never succeeds alone. In the other episodes the outcomes are independent.

    Args:
        first: Success rate of the first policy.
        second: Success rate of the second policy.
        shared: Share of the episodes with a common draw, 0 to 1.
    """
    p, q, s = (
        as_number(value, what, least=0.0, most=1.0) for value, what in ((first, "first"), (second, "second"), (shared, "shared"))
    )
    return s * max(p - q, 0.0) + (1 - s) * p * (1 - q), s * max(q - p, 0.0) + (1 - s) * q * (1 - p)


def paired_power(first: float, second: float, shared: float, episodes: int) -> float:
    """Return the power of the exact test: the probability that a difference is significant, with p up to `SIGNIFICANT`.

    Args:
        first: Success rate of the first policy.
        second: Success rate of the second policy.
        shared: Share of the episodes with a common draw, see `pair_shares`.
        episodes: Number of episodes that both play.

    Returns:
        Sum of the probabilities of all significant splits, over all numbers of pairs with different outcomes.
    """
    only_first, only_second = pair_shares(first, second, shared)
    episodes = as_whole(episodes, "episodes", least=0, most=20_000)
    differ = only_first + only_second
    if differ == 0.0:
        return 0.0
    total = 0.0
    for m, weight in enumerate(_binomial(episodes, min(1.0, differ))):
        if weight > 1e-12:
            lower = 2.0 * np.cumsum(_binomial(m, 0.5)[: (m + 1) // 2])
            critical = int(np.searchsorted(lower, SIGNIFICANT, side="right"))  # splits with fewer than this on one side
            chances = _binomial(m, only_second / differ)
            total += weight * float(chances[:critical].sum() + chances[m + 1 - critical :].sum())
    return float(total)


def episodes_needed(first: float, second: float, shared: float, power: float = 0.8) -> int:
    """Return the number of episodes that separates two rates with a probability of `power`, to about 2 %.

    Args:
        first: Success rate of the first policy.
        second: Success rate of the second policy, different from the first.
        shared: Share of the episodes with a common draw, see `pair_shares`.
        power: The probability.
    """
    power = as_number(power, "power", above=0.0, most=0.999)
    pair_shares(first, second, shared)  # checks the three values
    as_number(abs(first - second), "difference of the rates", least=0.01)
    enough = 5
    while paired_power(first, second, shared, enough) < power:
        enough = round(1.25 * enough)
    episodes = int(enough / 1.25)
    while episodes < enough and paired_power(first, second, shared, episodes) < power:
        episodes = max(episodes + 1, round(1.02 * episodes))
    return min(episodes, enough)


def _binomial(n: int, p: float) -> FloatArray:
    """Return P(X = k), k = 0 ... n, of a binomial distribution, by logarithms of factorials."""
    if p in (0.0, 1.0):
        return np.eye(n + 1)[n if p else 0]
    factorials = np.concatenate([[0.0], np.cumsum(np.log(np.arange(1, n + 1)))])
    k = np.arange(n + 1)
    logs = factorials[n] - factorials[k] - factorials[n - k] + k * np.log(p) + (n - k) * np.log1p(-p)
    return np.asarray(np.exp(logs))
