"""Write what is generated from docs/results/: tables in README.md and docs/performance.md, and docs/results/demo_success.md.

`make sweep` measures docs/results/demo_success.json; docs/results/benchmarks.json is a copy of what `make bench` wrote.
With `--check` nothing is written; it only says whether they fit.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path
from typing import Any

from rlbench_pin.checking.page import current_keys, interval, page, share

CAMERAS = ("naive ", "cpu ", "egl ")
"""How benchmarks of pictures begin."""
ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"

HEAD = (
    "| Task | Variations | First try (95 % interval) | Unseen seeds (95 % interval) | Same scene | Within {tries} tries | Stable "
    "| Replay | Key frames | Noop | Random | Length | Planning | x real time |\n"
    "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
)
NOTE = (
    "{episodes} demonstrations per task, seeds {seed} to {last}, at most {max_variations} variations each; {unseen} more on "
    "seeds from {unseen_seed}, which nobody looked at while the tasks were made. "
    "*Same scene*: solved, after a failure by up to {again} plans with other draws; *within {tries} tries*: after a failure "
    "the scene is drawn again. *Stable*: success still holds after 1 s with the arm stationary. "
    "*Replay*: the recorded joint-position actions succeed again (of {replays} demonstrations or more). "
    "*Key frames*: the poses at which a demonstration rests or moves its fingers, alone, planned anew, reach the goal. "
    "*Noop*, *random*: goals reached by the no-op policy and by random actions in 200 steps "
    "(random motion may hit a reach target). "
    "*Length*, *planning*: median of a demonstration. *x real time*: simulated over process time of reset and demonstration. "
    "Written by `make sweep`; [the whole report](docs/results/demo_success.md) has variations, legs and causes of failures."
)


def task_table(results: dict[str, Any]) -> str:
    """Return the table of tasks as Markdown."""
    results = dict(current_keys(results))
    lines = [HEAD.format(tries=results["max_attempts"]), *(_row(name, task) for name, task in results["tasks"].items())]
    settings = {key: results[key] for key in ("episodes", "seed", "max_variations")}
    settings |= {
        "unseen": results.get("unseen", 0),
        "unseen_seed": results.get("unseen_seed", 0),
        "tries": results["max_attempts"],
    }
    last, replays = (
        results["seed"] + results["episodes"] - 1,
        min(results["episodes"], results.get("replays", results["episodes"])),
    )
    note = NOTE.format(**settings, last=last, replays=replays, again=results["max_attempts"] - 1)
    return "\n".join([*lines, "", note])


def benchmark_table(run: dict[str, Any]) -> str:
    """Return the table of benchmarks as Markdown, durations in [ms]; those of single cameras stand in docs/cameras.md."""
    lines = ["| Benchmark | median ms | p95 ms | p99 ms | |", "|---|---:|---:|---:|---|"]
    for r in (r for r in run["results"] if not r["name"].startswith(CAMERAS)):
        numbers = " | ".join(f"{1000 * r[key]:.2f}" for key in ("median", "p95", "p99"))
        lines.append(f"| {r['name'].strip()} | {numbers} | {r['note']} |")
    versions = ", ".join(f"{name} {version}" for name, version in run["versions"].items())
    return "\n".join([*lines, "", f"Python {run['machine']['python']}, {run['machine']['machine']}; {versions}."])


def _row(name: str, task: dict[str, Any]) -> str:
    cells = [
        f"`{name}`",
        str(len(task["variations"])),
        interval(task["first_try"]),
        interval(task["unseen"]) if task.get("unseen", {}).get("of") else "",
        share(task.get("same_scene")),
        share(task["within_tries"]),
        share(task.get("stable_success")),
        share(task["replay"]),
        share(task.get("key_frames")),
        share(task["noop"]),
        share(task["random"]),
        f"{task['median_simulated_s']:.1f} s",
        f"{1000 * task['median_planning_s']:.0f} ms",
        f"{task['times_real_time']:.0f}",
    ]
    return "| " + " | ".join(cells) + " |"


def report_page(results: dict[str, Any]) -> str:
    """Return the whole report as Markdown, with the contact sheets of docs/images/sheets/."""
    sheets = {name: f"../images/sheets/{name}.jpg" for name in results["tasks"]}
    return page(results, {name: {"sheet": file} for name, file in sheets.items() if (RESULTS / file).is_file()})


def replace_part(text: str, name: str, content: str) -> str:
    """Put `content` between the markers called `name`."""
    begin, end = f"<!-- generated: {name} -->", f"<!-- /generated: {name} -->"
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
    if len(pattern.findall(text)) != 1:
        raise SystemExit(f"The document needs exactly one part between '{begin}' and '{end}'.")
    return pattern.sub(lambda _: f"{begin}\n{content}\n{end}", text)


# document, marker of the part (None: all of it), results, text
PARTS = (
    ("README.md", "tasks", "demo_success.json", task_table),
    ("docs/results/demo_success.md", None, "demo_success.json", report_page),
    ("docs/performance.md", "benchmarks", "benchmarks.json", benchmark_table),
)


def main() -> int:
    """Update, or check."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when something is out of date")
    arguments = parser.parse_args()
    outdated = []
    for document, marker, results, text in PARTS:
        if not (RESULTS / results).is_file():
            print(f"no docs/results/{results}, so {document} stays as it is", file=sys.stderr)
            continue
        file = ROOT / document
        before = file.read_text(encoding="utf-8") if file.is_file() else ""
        content = text(json.loads((RESULTS / results).read_text(encoding="utf-8")))
        after = content if marker is None else replace_part(before, marker, content)
        if before != after:
            outdated.append(document)
        if not arguments.check:
            file.write_text(after, encoding="utf-8")
    print(f"{'out of date' if arguments.check else 'updated'}: {', '.join(outdated) or 'nothing'}")
    return int(arguments.check and bool(outdated))


if __name__ == "__main__":
    sys.exit(main())
