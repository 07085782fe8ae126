"""Results of a protocol in the form of its published table: rows in the same order, means, and standard errors."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rlbench_pin.environment.episode import EVALUATION_SEEDS
from rlbench_pin.errors import InvalidValue
from rlbench_pin.evaluation.protocols.protocol import VARIATION, Protocol
from rlbench_pin.evaluation.results.records import EpisodeRecord, Results
from rlbench_pin.evaluation.results.tables import Table
from rlbench_pin.rates import Rate
from rlbench_pin.values import as_record

NO_CLAIM = "Scenes differ from those of RLBench: do not compare these numbers with published ones."


@dataclass(frozen=True)
class ProtocolRow:
    """A row of the table of a protocol, or a mean of rows."""

    title: str
    """Name in the published table."""
    episodes: int
    success: float
    """Success rate; for a mean, the mean of the success rates of its rows."""
    standard_error: float | None
    """Standard error of the rate over the repetitions; None with one repetition."""


@dataclass(frozen=True)
class ProtocolSummary:
    """Results of a policy with a protocol."""

    policy: str
    protocol: Protocol
    rows: tuple[ProtocolRow, ...]
    """Rows in the order of the published table."""
    means: tuple[ProtocolRow, ...]
    """Means over the rows of each part, and over all rows."""

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        protocol = {"name": self.protocol.label, "version": self.protocol.version, "sha256": self.protocol.sha256}
        return {**protocol, "rows": [vars(row) for row in self.rows], "means": [vars(row) for row in self.means]}


def summarise_protocol(results: Results) -> ProtocolSummary:
    """Return the rows and means of the published table of a protocol, from the episodes without factors.

    Args:
        results: Results of an evaluation with a protocol.

    Raises:
        InvalidValue: The evaluation had no protocol, or episodes are missing.
    """
    protocol = as_record(results, Results, "results").protocol
    if protocol is None:
        raise InvalidValue("results", results.policy, "were made without a protocol", "Evaluate with `--protocol NAME`.")
    test = protocol.split("test")
    found: dict[tuple[str, int], list[EpisodeRecord]] = {}
    for episode in results.of_factors("").episodes:
        found.setdefault((episode.task, episode.variation), []).append(episode)
    rows: list[tuple[str, str, list[EpisodeRecord]]] = []
    for task in protocol.selected:
        of_variation = {v: found.get((task.name, v), []) for v in task.variations}
        if protocol.episodes_of == VARIATION:
            rows += [(f"{task.title}+{v}", task.part, episodes) for v, episodes in of_variation.items()]
        else:
            rows.append((task.title, task.part, [e for episodes in of_variation.values() for e in episodes]))
    if empty := [title for title, _, episodes in rows if len(episodes) != test.episodes * len(test.seeds)]:
        raise InvalidValue("results", empty[0], "lack episodes of the protocol", "Evaluate with `--protocol` again.")
    repeated = [[_repetitions(protocol, episodes) for _, p, episodes in rows if part in ("", p)] for part in _parts(protocol)]
    what = "variations" if protocol.episodes_of == VARIATION else "tasks"
    means = [
        _row(
            f"mean over {what}{f' of {part}' * bool(part)}",
            [_mean(column) for column in zip(*rates)],
            len(rates) * len(rows[0][2]),
        )
        for part, rates in zip(_parts(protocol), repeated)
    ]
    lines = [_row(title, _repetitions(protocol, episodes), len(episodes)) for title, _, episodes in rows]
    return ProtocolSummary(results.policy, protocol, tuple(lines), tuple(means))


def _parts(protocol: Protocol) -> tuple[str, ...]:
    """Return the parts that have a mean; the empty one is all rows."""
    parts = tuple(dict.fromkeys(task.part for task in protocol.selected if task.part))
    return parts if len(parts) == 1 else (*parts, "")


def _repetitions(protocol: Protocol, episodes: Sequence[EpisodeRecord]) -> list[float]:
    """Return the rate of success of each repetition."""
    test = protocol.split("test")
    numbers = [((e.seed - EVALUATION_SEEDS) // 2, e.success) for e in episodes]
    chosen = [[success for n, success in numbers if seed <= n < seed + test.episodes] for seed in test.seeds]
    return [Rate(sum(some), len(some)).value for some in chosen]


def _row(title: str, rates: Sequence[float], episodes: int) -> ProtocolRow:
    error = statistics.stdev(rates) / math.sqrt(len(rates)) if len(rates) > 1 else None
    return ProtocolRow(title, episodes, _mean(rates), error)


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values)


def protocol_table(summary: ProtocolSummary) -> Table:
    """Return the published table of a protocol: one row per task or variation, then the means."""
    as_record(summary, ProtocolSummary, "summary")
    protocol, repetitions = summary.protocol, len(summary.protocol.split("test").seeds)
    head = ("task", "episodes", "success", *(("standard error",) if repetitions > 1 else ()))
    rows = [
        (row.title, str(row.episodes), f"{100 * row.success:.1f} %", *(() if error is None else (f"{100 * error:.1f}",)))
        for row in (*summary.rows, *summary.means)
        for error in [row.standard_error]
    ]
    title = f"{summary.policy}: protocol {protocol.label}, version {protocol.version}, {protocol.sha256[:12]}"
    over = [f"Standard error over {repetitions} repetitions, in percentage points."] if repetitions > 1 else []
    return Table(title, head, tuple(rows), (*over, NO_CLAIM))
