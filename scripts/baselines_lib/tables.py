"""The tables of docs/baselines.md and docs/results/baselines.md, from the stored results files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from reference_lib.docs import table
from update_readme import replace_part

from rlbench_pin.evaluation import Estimate, Results, Summary, read_results, summarise, task_table

from .rows import rows

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "docs" / "results" / "baselines"
PAGE, REPORT = ROOT / "docs" / "baselines.md", ROOT / "docs" / "results" / "baselines.md"
HEAD = ("Baseline", "Tasks", "Episodes", "Success", "95 %", "Stable success", "Actions refused", "Faults", "Commit")


def kept() -> dict[str, Results]:
    """Return row -> what was played of it, in the order of the rows; rows without results are left out."""
    names = [name for row in rows().values() for name in row.results]
    return {name: read_results(RESULTS / f"{name}.json") for name in names if (RESULTS / f"{name}.json").is_file()}


def summary_of(results: Results) -> Summary:
    """Return rates and intervals, the same at every call."""
    return summarise(results, np.random.default_rng(0))


def pages() -> dict[Path, str]:
    """Return page -> its text with the tables as they should be."""
    found = kept()
    scale = f"\n{scale_table(found)}\n\nEvery task is in [results/baselines.md](results/baselines.md).\n"
    return {PAGE: replace_part(PAGE.read_text(encoding="utf-8"), "scale", scale), REPORT: report(found)}


def scale_table(found: dict[str, Results]) -> str:
    """Return a row per baseline: the mean over its tasks."""
    return table(HEAD, [_row(name, results, summary_of(results)) for name, results in found.items()], "lrrrrrrrl")


def _row(name: str, results: Results, summary: Summary) -> tuple[str, ...]:
    refused = sum(sum(task.refused.values()) for task in summary.tasks) / max(1, summary.episodes)
    faults = sum(sum(task.faults.values()) for task in summary.tasks)
    counts = (str(len(summary.tasks)), str(summary.episodes))
    rates = (_percent(summary.success.value), _interval(summary.success), _percent(summary.stable.value))
    return f"`{name}`", *counts, *rates, f"{refused:.2f}", str(faults), f"`{results.commit[:7]}`"


def report(found: dict[str, Results]) -> str:
    """Return the page with every task of every baseline."""
    parts = [
        "# Baselines, task by task",
        "",
        "Written by `make baselines`. [../baselines.md](../baselines.md) describes each of them.",
    ]
    for name, results in found.items():
        parts += ["", f"## {name}", "", f"`{results.policy}`, commit `{results.commit[:12]}`.", "", _tasks(results)]
    return "\n".join(parts) + "\n"


def _tasks(results: Results) -> str:
    text = task_table(summary_of(results)).text(markdown=True)
    return text.split("\n", 2)[2]


def _percent(value: float) -> str:
    return f"{100 * value:.1f} %"


def _interval(estimate: Estimate) -> str:
    return f"{100 * estimate.low:.1f} to {100 * estimate.high:.1f}"
