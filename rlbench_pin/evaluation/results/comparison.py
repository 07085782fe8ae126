"""Comparison of two policies on the same episodes: episodes that only one of them solves, per task and for all tasks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from itertools import combinations
from typing import Literal

import numpy as np

from rlbench_pin.errors import IncompatibleResults, InvalidValue
from rlbench_pin.evaluation.protocols.protocol import Protocol
from rlbench_pin.evaluation.results.records import EpisodeRecord, Results
from rlbench_pin.evaluation.results.statistics import DRAWS, LEVEL, SIGNIFICANT, Estimate, PValues, holm, mcnemar
from rlbench_pin.values import as_choice, as_flag, as_names, as_record, as_several

Measure = Literal["success", "stable"]
"""Measure: success, or stable success."""
_FIELDS: dict[Measure, str] = {"success": "success", "stable": "lasts"}  # of an episode, by measure
IMPLIED = ("episodes", "seed", "variations", "time_limit")
"""Limits that may differ: the first three follow from the episodes, and the last is a wall-clock limit."""
_SHOWN = 3
_Episodes = dict[tuple[str, int, int], EpisodeRecord]
_ADVICE = "Evaluate both with the same `--tasks`, `--episodes` and `--seed`; `--common` compares the episodes that both have."
_LIMITS_ADVICE = "Evaluate both with the same limits, or compare them with `--any-limits`."
_VERSIONS_ADVICE = "Evaluate the older version again with this release; docs/versions.md explains versions."


@dataclass(frozen=True)
class Pairs:
    """Outcomes of two policies on the episodes of one task, or of all tasks. A pair is one episode played by both."""

    both: int
    """Number of pairs in which both succeeded."""
    only_first: int
    """Number of pairs in which only the first succeeded."""
    only_second: int
    """Number of pairs in which only the second succeeded."""
    neither: int
    """Number of pairs in which neither succeeded."""

    @property
    def of(self) -> int:
        """Number of all pairs."""
        return self.both + self.only_first + self.only_second + self.neither

    @property
    def difference(self) -> float:
        """Success rate of the second minus that of the first."""
        return (self.only_second - self.only_first) / self.of if self.of else 0.0

    @property
    def p(self) -> PValues:
        """p-values of McNemar's test."""
        return mcnemar(self.only_first, self.only_second)


@dataclass(frozen=True)
class TaskComparison:
    """Comparison of two policies on one task."""

    task: str
    pairs: Pairs
    p_holm: float
    """Exact p-value, corrected by Holm's method for the number of tasks."""

    @property
    def significant(self) -> bool:
        """Whether the difference is significant: the corrected p-value is below 0.05."""
        return self.p_holm < SIGNIFICANT


@dataclass(frozen=True)
class Comparison:
    """Comparison of two policies on the same episodes."""

    first: str
    second: str
    measure: Measure
    tasks: tuple[TaskComparison, ...]
    pairs: Pairs
    """Outcomes of all tasks together."""
    difference: Estimate
    """Mean over tasks of the success rate of the second minus that of the first, with a bootstrap interval."""
    remarks: tuple[str, ...]
    """Other differences between the files, which may explain the result."""

    @property
    def significant(self) -> bool:
        """Whether the difference over all tasks is significant: the exact p-value is below 0.05."""
        return self.pairs.p.exact < SIGNIFICANT


def compare(
    first: Results,
    second: Results,
    rng: np.random.Generator,
    *,
    measure: Measure = "success",
    common: bool = False,
    any_limits: bool = False,
) -> Comparison:
    """Compare two policies, episode by episode.

    Args:
        first: Results of the first policy.
        second: Results of the second policy on the same episodes: tasks, variations, seeds.
        rng: Random generator of the bootstrap.
        measure: `success`, or `stable` for success that still holds after 1 s.
        common: Compare only the common episodes if the episodes differ.
        any_limits: Compare although the limits of episodes differ.

    Raises:
        IncompatibleResults: Episodes, limits, versions of a task or protocols differ; the error names the differences.
    """
    one, other = (as_record(results, Results, "results") for results in (first, second))
    as_record(rng, np.random.Generator, "rng")
    as_choice(measure, "measure", _FIELDS)
    common, any_limits = as_flag(common, "common"), as_flag(any_limits, "any_limits")
    if one.factors or other.factors:
        raise InvalidValue("results", (one.policy, other.policy), "have factors", "Compare `results.of_factors(SETTING)`.")
    check_comparable((one, other), (one.policy, other.policy))
    before, after = _by_key(one), _by_key(other)
    _check_episodes(one, other, before, after, common)
    limits = _limit_differences(one, other)
    if limits and not any_limits:
        raise IncompatibleResults(one.policy, other.policy, limits, _LIMITS_ADVICE)
    counted = _counted(one, after, measure)
    corrected = holm([pairs.p.exact for pairs in counted.values()])
    tasks = tuple(TaskComparison(task, pairs, p) for (task, pairs), p in zip(counted.items(), corrected))
    together = Pairs(*(sum(column) for column in zip(*map(astuple, counted.values()))))
    difference = _mean_difference(tuple(counted.values()), rng)
    return Comparison(one.policy, other.policy, measure, tasks, together, difference, (*limits, *provenance_remarks(one, other)))


def check_comparable(results: Sequence[Results], labels: Sequence[str]) -> None:
    """Raise IncompatibleResults unless all results have the same protocol or none, and common tasks have the same versions.

    Args:
        results: The results.
        labels: Names of the results in the error.
    """
    found = [as_record(r, Results, "results") for r in as_several(results, "results")]
    labels = as_names(labels, "labels")
    if len(labels) != len(found):
        raise InvalidValue("labels", labels, f"have to be {len(found)} names, one for each result")
    for other, label in zip(found[1:], labels[1:]):
        before, now = found[0].protocol, other.protocol
        if (before and before.sha256) != (now and now.sha256):
            difference = f"protocol {_shown(before)} against {_shown(now)}"
            advice = "Show them one by one, or evaluate both with the same protocol."
            raise IncompatibleResults(labels[0], label, (difference,), advice)
    for (one, first), (other, second) in combinations(zip(found, labels), 2):
        if differences := _version_differences(one, other):
            raise IncompatibleResults(first, second, differences, _VERSIONS_ADVICE)


def _version_differences(one: Results, other: Results) -> list[str]:
    """Return a sentence for each common task with different versions."""
    versions = [(task, one.version_of(task), other.version_of(task)) for task in one.tasks if task in other.tasks]
    return [f"task '{task}' has version {a} in the first and {b} in the second" for task, a, b in versions if a != b]


def _shown(protocol: Protocol | None) -> str:
    return "none" if protocol is None else f"{protocol.name} version {protocol.version} ({protocol.sha256[:12]})"


def _counted(one: Results, after: _Episodes, measure: Measure) -> dict[str, Pairs]:
    """Return the outcomes of the common episodes, by task."""
    found: dict[str, list[tuple[bool, bool]]] = {task: [] for task in one.tasks}
    for episode in one.episodes:
        if (same := after.get(_key(episode))) is not None:
            found[episode.task].append((getattr(episode, _FIELDS[measure]), getattr(same, _FIELDS[measure])))
    return {task: _pairs(outcomes) for task, outcomes in found.items() if outcomes}


def _by_key(results: Results) -> _Episodes:
    return {_key(episode): episode for episode in results.episodes}


def _key(episode: EpisodeRecord) -> tuple[str, int, int]:
    return episode.task, episode.variation, episode.seed


def _check_episodes(one: Results, other: Results, before: _Episodes, after: _Episodes, common: bool) -> None:
    """Raise IncompatibleResults unless both have the same episodes, or `common` is set and some episodes are common."""
    shared = before.keys() & after.keys()
    if shared and (common or len(shared) == len(before) == len(after)):
        return
    parts: tuple[tuple[str, Sequence[object], Sequence[object]], ...] = (
        ("tasks", one.tasks, other.tasks),
        ("seeds", one.seeds, other.seeds),
    )
    found = [text for what, a, b in parts if (text := _difference(what, a, b))]
    if not found:
        found = [_difference("episodes (task, variation, seed)", tuple(before), tuple(after)) or "neither has an episode"]
    raise IncompatibleResults(one.policy, other.policy, found, "They have no episode in common." if not shared else _ADVICE)


def _difference(what: str, a: Sequence[object], b: Sequence[object]) -> str:
    """Return the items that only one of two lists has, as text; empty if there are none."""
    texts = []
    for which, here, there in (("first", a, set(b)), ("second", b, set(a))):
        if only := [item for item in here if item not in there]:
            more = f" and {len(only) - _SHOWN} more" if len(only) > _SHOWN else ""
            texts.append(f"only the {which} has {what} {', '.join(map(str, only[:_SHOWN]))}{more}")
    return "; ".join(texts)


def _limit_differences(one: Results, other: Results) -> list[str]:
    names = [name for name in sorted({*one.limits, *other.limits}) if name not in IMPLIED]
    pairs = [(name, one.limits.get(name), other.limits.get(name)) for name in names]
    return [f"{name} is {a!r} in the first and {b!r} in the second" for name, a, b in pairs if a != b]


def provenance_remarks(one: Results, other: Results) -> list[str]:
    """Return sentences about different versions and commits, with which the same seed may give another episode."""
    names = sorted({*one.versions, *other.versions})
    versions = [f"{name} {one.versions.get(name)} and {other.versions.get(name)}" for name in names]
    found = [text for name, text in zip(names, versions) if one.versions.get(name) != other.versions.get(name)]
    remarks = [f"They were made with different versions: {', '.join(found)}."] if found else []
    if one.commit != other.commit:
        remarks.append(f"They were made at different commits: {one.commit or 'none'} and {other.commit or 'none'}.")
    return remarks


def _pairs(outcomes: Sequence[tuple[bool, bool]]) -> Pairs:
    counts = {(a, b): 0 for a in (True, False) for b in (True, False)}
    for a, b in outcomes:
        counts[a, b] += 1
    return Pairs(counts[True, True], counts[True, False], counts[False, True], counts[False, False])


def _mean_difference(strata: Sequence[Pairs], rng: np.random.Generator) -> Estimate:
    """Return the mean over tasks of the difference, with a bootstrap that resamples pairs within each task.

    If all pairs of a task are of one kind, half a pair is added to each kind of difference, for the spread only.
    """
    spread = np.zeros(DRAWS)
    for pairs in strata:
        counts = np.array([pairs.only_first, pairs.only_second, pairs.both + pairs.neither], dtype=np.float64)
        if counts.max() == pairs.of:
            counts += (0.5, 0.5, 0.0)
        shares = counts / counts.sum()
        drawn = rng.multinomial(pairs.of, shares, DRAWS)
        spread += (drawn[:, 1] - drawn[:, 0]) / pairs.of - (shares[1] - shares[0])
    value = float(np.mean([pairs.difference for pairs in strata]))
    low, high = np.quantile(spread / len(strata), LEVEL)
    return Estimate(value, max(-1.0, value + min(0.0, float(low))), min(1.0, value + max(0.0, float(high))))
