"""How long policies take to answer: a file beside the results, because no two runs have the same times."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.evaluation.run.config import EvaluationConfig
from rlbench_pin.evaluation.run.episode import EpisodeOutcome
from rlbench_pin.evaluation.run.origin import machine

_FORMAT = 1


def times_path(results: Path) -> Path:
    """Return where the times beside a results file lie: `x.times.json` beside `x.json`."""
    return results.with_name(f"{results.stem}.times.json")


def write_times(path: Path, config: EvaluationConfig, outcomes: Sequence[EpisodeOutcome]) -> Path:
    """Write the time per action of each task, and of all.

    Args:
        path: Where to.
        config: What was evaluated.
        outcomes: All its episodes.

    Raises:
        StorageError: The disk cannot be written to.
    """
    tasks = dict.fromkeys(outcome.item.name for outcome in outcomes)
    content = {
        "format": _FORMAT,
        "policy": config.policy,
        "machine": machine(),
        "tasks": {task: _summary([o for o in outcomes if o.item.name == task]) for task in tasks},
        "all": _summary(outcomes),
    }
    return write_whole(path, (json.dumps(content, indent=1) + "\n").encode())


def _summary(outcomes: Sequence[EpisodeOutcome]) -> dict[str, float | int | None]:
    """Return how many answers there were, and median, 95th percentile and longest of their times [s]."""
    times = np.array([t for outcome in outcomes for t in outcome.action_times])
    if not len(times):
        return {"actions": 0, "median_s": None, "p95_s": None, "max_s": None}
    values = {"median_s": np.median(times), "p95_s": np.quantile(times, 0.95), "max_s": times.max()}
    return {"actions": len(times), **{name: round(float(value), 6) for name, value in values.items()}}
