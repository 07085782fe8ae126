"""Write the pages that are generated from docs/results/: demo_success.md, benchmarks.md, and a summary in README.md.

`make sweep` measures docs/results/demo_success.json; docs/results/benchmarks.json is a copy of the output of `make bench`.
With `--check` nothing is written; it only reports whether the pages are up to date.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rlbench_pin.checking.page import current_keys, interval, page
from rlbench_pin.evaluation.sets import gembench_tasks, public_tasks, variant_tasks
from rlbench_pin.tasks import task_class

CAMERAS = ("naive ", "cpu ", "egl ")
"""First words of the names of camera benchmarks."""
ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"


def variations(names: Iterable[str]) -> int:
    """Return how many variations tasks have in all."""
    kinds = map(task_class, names)
    return sum(kind.variation_count(object.__new__(kind)) for kind in kinds)


def counts(_: dict[str, Any]) -> str:
    """Return the sentence that counts tasks and variations."""
    public, variants, further = public_tasks(), variant_tasks(), gembench_tasks()
    return (
        f"{len(public) + len(variants)} tasks with {variations((*public, *variants))} variations: "
        f"the {len(public)} public tasks of RLBench with {variations(public)}, "
        f"and {len(variants)} known variants with {variations(variants)}. "
        f"GemBench adds {len(further)} tasks with {variations(further)}."
    )


def summary(results: dict[str, Any]) -> str:
    """Return the line of all tasks and the worst one."""
    tasks = dict(current_keys(results))["tasks"]
    parts = {"seeds used in development": "first_try", "unseen seeds": "unseen"}
    lines = ["| Demonstrations at the first try | All tasks | Worst task |", "|---|---:|---|"]
    for title, key in parts.items():
        rates = {name: task[key] for name, task in tasks.items() if task.get(key, {}).get("of")}
        count, of = (sum(rate[part] for rate in rates.values()) for part in ("count", "of"))
        worst = min(rates, key=lambda name: rates[name]["rate"], default="")
        lines.append(f"| {title} | {count} of {of} ({100 * count / of:.1f} %) | `{worst}`, {interval(rates[worst])} |")
    return "\n".join(lines)


def benchmark_page(run: dict[str, Any]) -> str:
    """Return the page of the last benchmark run as Markdown."""
    return f"# Benchmarks\n\nProcessor times of the last complete `make bench`.\n\n{benchmark_table(run)}\n"


def benchmark_table(run: dict[str, Any]) -> str:
    """Return the table of benchmarks as Markdown, durations in [ms]; docs/results/rendering_notes.md has single cameras."""
    lines = ["| Benchmark | median ms | p95 ms | p99 ms | |", "|---|---:|---:|---:|---|"]
    for r in (r for r in run["results"] if not r["name"].startswith(CAMERAS)):
        numbers = " | ".join(f"{1000 * r[key]:.2f}" for key in ("median", "p95", "p99"))
        lines.append(f"| {r['name'].strip()} | {numbers} | {r['note']} |")
    versions = ", ".join(f"{name} {version}" for name, version in run["versions"].items())
    return "\n".join([*lines, "", f"Python {run['machine']['python']}, {run['machine']['machine']}; {versions}."])


def report_page(results: dict[str, Any]) -> str:
    """Return the whole report as Markdown, with the contact sheets of docs/images/sheets/."""
    sheets = {name: f"../images/sheets/{name}.jpg" for name in results["tasks"]}
    return page(results, {name: {"sheet": file} for name, file in sheets.items() if (RESULTS / file).is_file()})


def replace_part(text: str, name: str, content: str) -> str:
    """Put `content` between the markers called `name`."""
    begin, end = f"<!-- generated: {name} -->", f"<!-- /generated: {name} -->"
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.DOTALL)
    if len(pattern.findall(text)) != 1:
        raise SystemExit(f"The document has to contain exactly one part between '{begin}' and '{end}'.")
    return pattern.sub(lambda _: f"{begin}\n{content}\n{end}", text)


def checks_only(description: str | None) -> bool:
    """Read the command line of a script that writes pages: whether it has `--check`."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when a page is out of date")
    return bool(parser.parse_args().check)


def write_pages(check: bool, pages: Mapping[Path, str]) -> int:
    """Write the texts of pages, or with `check` only print which are out of date; return the exit status."""
    outdated = [file for file, text in pages.items() if not file.is_file() or file.read_text(encoding="utf-8") != text]
    for file in () if check else outdated:
        file.write_text(pages[file], encoding="utf-8")
    print(f"{'out of date' if check else 'updated'}: {', '.join(file.name for file in outdated) or 'nothing'}")
    return int(check and bool(outdated))


# document, marker of the part (None: all of it), results, text
PARTS = (
    ("README.md", "counts", "demo_success.json", counts),
    ("README.md", "tasks", "demo_success.json", summary),
    ("docs/results/demo_success.md", None, "demo_success.json", report_page),
    ("docs/results/benchmarks.md", None, "benchmarks.json", benchmark_page),
)


def main() -> int:
    """Update, or check."""
    check, pages = checks_only(__doc__), dict[Path, str]()
    for document, marker, results, text in PARTS:
        if not (RESULTS / results).is_file():
            print(f"no docs/results/{results}, so {document} is not changed", file=sys.stderr)
            continue
        file = ROOT / document
        content = text(json.loads((RESULTS / results).read_text(encoding="utf-8")))
        if marker is not None:
            content = replace_part(pages.get(file) or file.read_text(encoding="utf-8"), marker, content)
        pages[file] = content
    return write_pages(check, pages)


if __name__ == "__main__":
    sys.exit(main())
