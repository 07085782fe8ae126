"""Write docs/leaderboard.md: a table for each protocol, from the results files of docs/results/submissions/.

Baselines of docs/results/baselines/ that follow a protocol are listed too. A file that does not qualify is an error.
With `--check` nothing is written; it only reports whether the page is out of date.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from reference_lib.docs import table
from update_readme import checks_only, write_pages

from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.evaluation import Protocol, Results, load_protocol, protocol_names, read_results, summarise, summarise_protocol
from rlbench_pin.evaluation.results.protocol_table import NO_CLAIM
from rlbench_pin.evaluation.results.tables import printable

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = DOCS / "leaderboard.md"
SUBMISSIONS, BASELINES = DOCS / "results" / "submissions", DOCS / "results" / "baselines"
HEAD = ("Policy", "Success", "95 %", "Episodes", "Commit", "File")
START = f"""# Leaderboard

A table for each [protocol](protocols.md), best policy first. *Success* is the mean over tasks, with its bootstrap interval
([results files](results_files.md#compare-policies)). Rows of one table have the same episodes of the same protocol,
and the same [versions of tasks](versions.md). {NO_CLAIM}

`python scripts/write_leaderboard.py` writes this page from the results files.
"""
END = """
## How to submit

1. Evaluate by a protocol, from a clean checkout: `rlbench-pin evaluate POLICY --protocol peract18 --out out/NAME_peract18.json`.
2. Verify the file: `rlbench-pin results verify out/NAME_peract18.json --sample 5% --policy POLICY`.
3. Copy it to `docs/results/submissions/` and run `python scripts/write_leaderboard.py`.
4. Open a pull request with both files. Say what the policy was trained on, and where its code and weights are.

Reviewers verify a sample with your policy, so a file whose policy nobody else can run is not listed.
The script refuses files without a protocol, with missing episodes, with factors, with changed protocols, and from a checkout
with changes.
"""


class NotForThePage(RlbenchPinError):
    """A results file does not belong on the leaderboard."""

    def __init__(self, path: Path, problem: str, advice: str) -> None:
        super().__init__(f"'{path}' cannot be on the leaderboard: {problem}. {advice}")


@dataclass(frozen=True)
class Entry:
    """A results file of the page."""

    path: Path
    results: Results
    protocol: Protocol

    @property
    def versions(self) -> tuple[int, ...]:
        """Versions of its tasks, in the order of the protocol."""
        return tuple(self.results.version_of(task) for task in self.protocol.task_names)


def checked(path: Path) -> Entry:
    """Read a results file that is to be on the page.

    Raises:
        ResultsFileError: It is no results file.
        NotForThePage: It does not belong on the page; says why.
    """
    results = read_results(path)
    protocol = results.protocol
    if protocol is None:
        raise NotForThePage(path, "it follows no protocol", "Evaluate with `--protocol NAME`.")
    if results.factors:
        raise NotForThePage(path, "it has factors of generalisation", "Evaluate without `--factors`.")
    if protocol.name in protocol_names():
        published = load_protocol(protocol.name)
        if published.version == protocol.version and published.sha256 != protocol.sha256:
            problem = f"its protocol '{protocol.name}' has other content than the published one"
            raise NotForThePage(path, problem, "Evaluate with the published protocol, or give yours another name.")
    if not re.fullmatch("[0-9a-f]{40}", results.commit):
        problem = f"its commit is '{results.commit}'"
        raise NotForThePage(path, problem, "Evaluate from a checkout without changes.")
    summarise_protocol(results)  # raises where episodes are missing
    return Entry(path, results, protocol)


def entries(submissions: Path = SUBMISSIONS, baselines: Path = BASELINES) -> list[Entry]:
    """Return the entries of the page: all submissions, and the baselines that follow a protocol."""
    further = [path for path in sorted(baselines.glob("*.json")) if read_results(path).protocol is not None]
    return [checked(path) for path in (*sorted(submissions.glob("*.json")), *further)]


def page(listed: Sequence[Entry]) -> str:
    """Return the page as Markdown."""
    tables: dict[tuple[str, int, str, tuple[int, ...]], list[Entry]] = {}
    for entry in listed:
        protocol = entry.protocol
        tables.setdefault((protocol.label, protocol.version, protocol.sha256, entry.versions), []).append(entry)
    return "\n".join([START, *(_section(some) for _, some in sorted(tables.items(), key=lambda item: item[0])), END.lstrip("\n")])


def _section(of_protocol: Sequence[Entry]) -> str:
    protocol, versions = of_protocol[0].protocol, dict(zip(of_protocol[0].protocol.task_names, of_protocol[0].versions))
    later = [f"`{task}` {version}" for task, version in versions.items() if version > 1]
    tasks = f"{', '.join(later)}, all others 1" if later else "1 for all tasks"
    rows = sorted(((summarise(e.results, np.random.default_rng(0)).success, e) for e in of_protocol), key=lambda r: -r[0].value)
    cells = [
        (
            f"`{printable(entry.results.policy.partition('?')[0])}`",
            f"{100 * success.value:.1f} %",
            f"{100 * success.low:.1f} to {100 * success.high:.1f}",
            str(len(entry.results.episodes)),
            f"`{entry.results.commit[:8]}`",
            f"[{entry.path.name}]({entry.path.relative_to(DOCS) if entry.path.is_relative_to(DOCS) else entry.path.name})",
        )
        for success, entry in rows
    ]
    title = f"## {protocol.label}, version {protocol.version}"
    return f"{title}\n\nSHA-256 `{protocol.sha256[:12]}`. Versions of tasks: {tasks}.\n\n{table(HEAD, cells, 'lrrrll')}\n"


def main() -> int:
    """Write the page, or check it."""
    check = checks_only(__doc__)
    try:
        return write_pages(check, {PAGE: page(entries())})
    except RlbenchPinError as error:
        print(error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
