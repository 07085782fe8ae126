"""The learning curve: success over the number of demonstrations, for each task and in the mean."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.evaluation.results.records import Results
from rlbench_pin.evaluation.results.statistics import Estimate, Summary, summarise
from rlbench_pin.evaluation.results.tables import Table
from rlbench_pin.rates import Rate
from rlbench_pin.values import as_record, as_text

FORMAT = 1


@dataclass(frozen=True)
class ShotsResult:
    """What came of one number of demonstrations."""

    shots: int
    summary: Summary
    sha256: str
    """Checksum of the results file."""


@dataclass(frozen=True)
class LearningCurve:
    """What came of a run of the challenge."""

    learner: str
    split: str
    points: tuple[ShotsResult, ...]
    """By rising number of demonstrations."""

    def table(self) -> Table:
        """Return it as a table, a row per task and one for the mean."""
        head = ("task", *(f"{p.shots} shot{'s' if p.shots > 1 else ''}" for p in self.points))
        rates = [{task.task: task.success for task in point.summary.tasks} for point in self.points]
        rows = [(name, *(_rate(of_point[name]) for of_point in rates)) for name in rates[0]] if rates else []
        rows.append(("mean over tasks", *(_cell(point.summary.success) for point in self.points)))
        title = f"{self.learner} on the challenge {self.split}: success, with its interval of 95 %"
        return Table(title, head, tuple(rows))

    def content(self) -> dict[str, Any]:
        """Return it as plain data."""
        points = [{"shots": p.shots, "results_sha256": p.sha256, **_content(p.summary)} for p in self.points]
        return {"format": FORMAT, "learner": self.learner, "split": self.split, "points": points}

    def write(self, path: Path) -> Path:
        """Write it as JSON.

        Raises:
            StorageError: The disk cannot be written to.
        """
        return write_whole(path, (json.dumps(self.content(), indent=1) + "\n").encode())


def learning_curve(learner: str, split: str, results: Mapping[int, Results]) -> LearningCurve:
    """Return what came of a run.

    Args:
        learner: What the learner is called.
        split: Which tasks it met.
        results: Number of demonstrations -> the evaluation with so many.
    """
    learner, split = as_text(learner, "learner"), as_text(split, "split")
    as_record(results, Mapping, "results")  # type: ignore[type-abstract]
    rng = np.random.default_rng(0)
    points = [ShotsResult(k, summarise(results[k], rng), results[k].sha256) for k in sorted(results)]
    return LearningCurve(learner, split, tuple(points))


def _content(summary: Summary) -> dict[str, Any]:
    tasks = {task.task: _estimate(task.success).as_dict() for task in summary.tasks}
    return {"episodes": summary.episodes, "mean": summary.success.as_dict(), "tasks": tasks}


def _estimate(rate: Rate) -> Estimate:
    return Estimate(rate.value, *rate.interval)


def _rate(rate: Rate) -> str:
    return _cell(_estimate(rate))


def _cell(value: Estimate) -> str:
    return f"{100 * value.value:.0f} % ({100 * value.low:.0f} to {100 * value.high:.0f})"
