"""Write docs/results/factors.md: what factors of generalisation cost a policy.

`python scripts/write_factor_results.py FILE...` adds the profiles of results files to docs/results/factors.json, replaces
earlier ones of the same policy and the same settings, and writes the page. Files of one policy and commit with the same
episodes form one table.
Without files it writes the page from factors.json, and the figure of the losses of two baselines, docs/images/factor_losses.png.
With `--check` nothing is written; it only reports whether the page is out of date.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

sys.path.insert(0, str(Path(__file__).parent))

from reference_lib.docs import table
from update_readme import write_pages

from rlbench_pin.environment.factors import factor_catalogue
from rlbench_pin.evaluation import read_results
from rlbench_pin.evaluation.results.plots import COLORS, write_plot
from rlbench_pin.evaluation.results.profile import factor_profile

RESULTS = Path(__file__).resolve().parents[1] / "docs" / "results"
DATA, PAGE = RESULTS / "factors.json", RESULTS / "factors.md"
FIGURE = RESULTS.parent / "images" / "factor_losses.png"
BASELINES = ("classical", "key_frames")
"""Policies in the figure."""
LOW = 0.9
"""Tasks whose success is below this share are named."""
HEAD = """# Factors of generalisation: results

Success with each [factor](../factors.md) alone, and the paired difference to the same episodes without it.
Both are means over tasks, with intervals of 95 %.
Written by `python scripts/write_factor_results.py FILE...` from results files.
"""


def stored() -> list[dict[str, Any]]:
    """Return the entries of factors.json."""
    found: list[dict[str, Any]] = json.loads(DATA.read_text(encoding="utf-8")) if DATA.is_file() else []
    return found


def entry_of(path: Path) -> dict[str, Any]:
    """Return the entry of a results file."""
    results = read_results(path)
    profile = factor_profile(results)
    name = results.policy.partition("?")[0]
    low = {
        row.setting: {t.task: f"{t.success.count} of {t.success.of}" for t in row.summary.tasks if t.success.value < LOW}
        for row in profile.rows
    }
    head = {"policy": name, "commit": results.commit, "results_sha256": results.sha256, "tasks": len(results.tasks)}
    return {**head, "episodes": profile.base.episodes, **profile.as_dict(), "low": low}


def joined(entries: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return one entry for each policy, commit and set of episodes, with the factors of all."""
    found: dict[str, dict[str, Any]] = {}
    for entry in entries:
        first = found.setdefault(json.dumps([entry["policy"], entry["commit"], entry["none"]]), entry)
        if first is not entry:
            first["factors"] += entry["factors"]
            first["low"] |= entry["low"]
    return list(found.values())


def without(entry: dict[str, Any], made: list[dict[str, Any]]) -> dict[str, Any]:
    """Return an entry without the rows that newer entries of its policy contain."""
    newer = {row["factors"] for new in made if new["policy"] == entry["policy"] for row in new["factors"]}
    return {**entry, "factors": [row for row in entry["factors"] if row["factors"] not in newer]}


def page(entries: list[dict[str, Any]]) -> str:
    """Return the page as Markdown."""
    return "\n".join([HEAD, *map(_section, entries)])


def _section(entry: dict[str, Any]) -> str:
    rows = [("none", str(entry["tasks"]), str(entry["episodes"]), _rate(entry["none"]), "", "")]
    for row in entry["factors"]:
        low = ", ".join(f"`{task}` {count}" for task, count in entry["low"][row["factors"]].items())
        difference = f"{100 * row['difference']['value']:+.1f} ({_span(row['difference'])})"
        rows.append((f"`{row['factors']}`", str(row["tasks"]), str(row["episodes"]), _rate(row["success"]), difference, low))
    head = ("Factor", "Tasks", "Episodes", "Success [%]", "Difference", f"Tasks below {100 * LOW:.0f} %")
    columns = len(head) if entry["none"]["value"] else len(head) - 1  # a policy that never succeeds is low on every task
    text = f"At commit `{entry['commit'][:8]}`. Factors in the training data: {entry['trained_on'] or 'not stated'}."
    title = f"{entry['policy']}, episodes per task: {entry['episodes'] // entry['tasks']}"
    return f"## {title}\n\n{text}\n\n{table(head[:columns], [row[:columns] for row in rows], 'lrrrrl'[:columns])}\n"


def losses(entries: Sequence[dict[str, Any]]) -> Figure:
    """Draw the paired differences of some entries, one line for each setting, with their intervals."""
    names = list(dict.fromkeys(row["factors"] for entry in entries for row in entry["factors"]))
    names.sort(key=lambda name: list(factor_catalogue()).index(name.partition(":")[0]))
    figure = Figure(figsize=(7.5, 0.26 * len(names) + 1.1), layout="constrained")
    axes = figure.add_subplot()
    axes.axvline(0.0, color="black", linewidth=0.8)
    for place, entry in enumerate(entries):
        differences = [row["difference"] for row in entry["factors"]]
        at = [names.index(row["factors"]) + 0.24 * (place - (len(entries) - 1) / 2) for row in entry["factors"]]
        values = 100.0 * np.array([d["value"] for d in differences])
        spread = np.abs(100.0 * np.array([d["interval_95"] for d in differences]).T - values)
        label = f"{entry['policy']}: {entry['tasks']} tasks, {entry['episodes']} episodes per factor at most"
        axes.errorbar(values, at, xerr=spread, fmt="o", markersize=4, linewidth=1.2, capsize=2, color=COLORS[place], label=label)
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_xlabel("difference to the same episodes without factors [percentage points], with 95 % intervals")
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    figure.legend(loc="outside upper center", ncols=len(entries), frameon=False)
    return figure


def _rate(estimate: dict[str, Any]) -> str:
    return f"{100 * estimate['value']:.1f} ({_span(estimate)})"


def _span(estimate: dict[str, Any]) -> str:
    low, high = estimate["interval_95"]
    return f"{100 * low:.1f} to {100 * high:.1f}"


def main() -> int:
    """Take files in, write the page, or check it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE", help="results files of evaluations with factors")
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when the page is out of date")
    arguments = parser.parse_args()
    made = joined([entry_of(path) for path in arguments.files])
    kept = [entry for entry in (without(old, made) for old in stored()) if entry["factors"]]
    entries = sorted([*kept, *made], key=lambda entry: entry["policy"])
    if not arguments.check:
        DATA.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
        write_plot(FIGURE, lambda: losses([entry for entry in entries if entry["policy"] in BASELINES]))
    return write_pages(arguments.check, {PAGE: page(entries)})


if __name__ == "__main__":
    sys.exit(main())
