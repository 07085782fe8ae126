"""Write docs/results/protocols.md: results of policies by the published protocols, in the order of the published tables.

`python scripts/write_protocol_results.py FILE...` adds the rows of results files to docs/results/protocols.json, replaces
earlier ones of the same policy and protocol, and writes the page. Without files it writes the page from protocols.json.
With `--check` nothing is written; it only reports whether the page is out of date.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from reference_lib.docs import table
from update_readme import write_pages

from rlbench_pin.evaluation import read_results
from rlbench_pin.evaluation.results.protocol_table import NO_CLAIM, summarise_protocol

RESULTS = Path(__file__).resolve().parents[1] / "docs" / "results"
DATA, PAGE = RESULTS / "protocols.json", RESULTS / "protocols.md"
HEAD = f"""# Protocols: results

Success by the protocols of [../protocols.md](../protocols.md), in the order of the published tables, in per cent;
± is the standard error over repetitions. {NO_CLAIM}
Written by `python scripts/write_protocol_results.py FILE...` from results files.
"""


def stored() -> list[dict[str, Any]]:
    """Return the entries of protocols.json."""
    found: list[dict[str, Any]] = json.loads(DATA.read_text(encoding="utf-8")) if DATA.is_file() else []
    return found


def with_file(entries: list[dict[str, Any]], path: Path) -> list[dict[str, Any]]:
    """Return the entries with that of a results file, in place of one of the same policy and protocol.

    Raises:
        SystemExit: An entry of another policy has other versions of the tasks.
    """
    results = read_results(path)
    name = results.policy.partition("?")[0]
    entry = {"policy": name, "commit": results.commit, "results_sha256": results.sha256, **summarise_protocol(results).as_dict()}
    entry["later_tasks"] = {task: version for task in results.tasks if (version := results.version_of(task)) > 1}
    kept = [old for old in entries if (old["policy"], old["name"]) != (name, entry["name"])]
    for old in kept:
        if old["name"] == entry["name"] and old.get("later_tasks", {}) != entry["later_tasks"]:
            versions = f"{old['policy']} has {old.get('later_tasks', {})} beyond version 1, {name} {entry['later_tasks']}"
            sys.exit(f"'{path}' has other versions of tasks: {versions}. Evaluate both with one release.")
    return sorted([*kept, entry], key=lambda e: (e["name"], e["policy"]))


def page(entries: list[dict[str, Any]]) -> str:
    """Return the page as Markdown."""
    names = dict.fromkeys(entry["name"] for entry in entries)
    return "\n".join([HEAD, *(_section(name, [entry for entry in entries if entry["name"] == name]) for name in names)])


def _section(name: str, entries: list[dict[str, Any]]) -> str:
    """Return the table of one protocol: a column for each policy."""
    rows = [
        (first["title"], str(first["episodes"]), *(_cell(entry[kind][place]) for entry in entries))
        for kind in ("rows", "means")
        for place, first in enumerate(entries[0][kind])
    ]
    policies = [entry["policy"] for entry in entries]
    head = ("Task", "Episodes", *(f"`{policy}`" for policy in policies))
    made = ", ".join(f"`{entry['policy']}` at commit `{entry['commit'][:8]}`" for entry in entries)
    version = f"Version {entries[0]['version']}, SHA-256 `{entries[0]['sha256'][:12]}`."
    return f"## {name}\n\n{version} Played: {made}.\n\n{table(head, rows, 'lr' + 'r' * len(policies))}\n"


def _cell(row: dict[str, Any]) -> str:
    error = row["standard_error"]
    return f"{100 * row['success']:.1f}" + ("" if error is None else f" ± {100 * error:.1f}")


def main() -> int:
    """Take files in, write the page, or check it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE", help="results files of evaluations by a protocol")
    parser.add_argument("--check", action="store_true", help="change nothing; exit 1 when the page is out of date")
    arguments = parser.parse_args()
    entries = stored()
    for path in arguments.files:
        entries = with_file(entries, path)
    if not arguments.check:
        DATA.write_text(json.dumps(entries, indent=1) + "\n", encoding="utf-8")
    return write_pages(arguments.check, {PAGE: page(entries)})


if __name__ == "__main__":
    sys.exit(main())
