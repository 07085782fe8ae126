"""`rlbench-pin results FILE...`: print tables and comparisons of results files, draw plots, and play episodes again."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tyro

from rlbench_pin.cli.options import MaybePath, SomeFiles, check_at_least, check_file, make_engine
from rlbench_pin.errors import TaskEnvironmentError

if TYPE_CHECKING:
    from rlbench_pin.evaluation.results.comparison import Comparison
    from rlbench_pin.evaluation.results.protocol_table import ProtocolSummary
    from rlbench_pin.evaluation.results.records import Results
    from rlbench_pin.evaluation.results.statistics import PValues, Summary
    from rlbench_pin.evaluation.run.verify import EpisodeDifference


Share = Annotated[str, tyro.conf.arg(metavar="PERCENT%")]
"""A share of episodes."""
ResultsFile = tyro.conf.Positional[Annotated[Path, tyro.conf.arg(metavar="FILE")]]
PolicyName = Annotated[str, tyro.conf.arg(metavar="POLICY", help_behavior_hint="(default: that of the file)")]


@dataclass(frozen=True)
class ShowResults:
    """Print tables of results files, compare them episode by episode, plot them.

    Success has a 95 % confidence interval: Wilson for a task, a bootstrap stratified by task for the mean over tasks.
    """

    files: tyro.conf.Positional[SomeFiles] = ()
    """Results files, as `rlbench-pin evaluate` writes them."""
    compare: bool = False
    """Compare each further file with the first: McNemar's test on the common episodes, by task and overall."""
    stable: bool = False
    """Compare stable success instead of success."""
    common: bool = False
    """Compare only the common episodes of two files with different episodes."""
    any_limits: bool = False
    """Compare files whose episodes have different limits."""
    plot: MaybePath = None
    """PNG or SVG file for a plot of the success by task, with the files side by side."""
    markdown: bool = False
    """Print the tables in Markdown."""
    json: bool = False
    """Print JSON for programs."""

    def run(self) -> int:
        """Print the tables, and draw the plot."""
        from rlbench_pin.evaluation.results.comparison import check_comparable
        from rlbench_pin.evaluation.results.plots import check_plot, draw_results
        from rlbench_pin.evaluation.results.protocol_table import protocol_table, summarise_protocol
        from rlbench_pin.evaluation.results.records import read_results
        from rlbench_pin.evaluation.results.statistics import summarise
        from rlbench_pin.evaluation.results.tables import comparison_table, overview_table, task_table

        if not self.files:
            raise TaskEnvironmentError(
                "No file was named. Use `rlbench-pin results FILE...`; `rlbench-pin evaluate` writes results files."
            )
        if self.compare and len(self.files) < 2:
            raise TaskEnvironmentError(
                f"--compare needs two files or more, but only '{self.files[0]}' was named. Name the files to compare with it."
            )
        if self.plot is not None:
            check_plot(self.plot, len(self.files))
            check_file(self.plot)
        results = [read_results(path) for path in self.files]
        labels = self.labels(results)
        check_comparable(results, labels)
        if any(r.factors for r in results):
            return self.show_profiles(results, labels)
        followed = [replace(summarise_protocol(r), policy=label) for r, label in zip(results, labels) if r.protocol]
        summaries = [replace(summarise(r, np.random.default_rng(0)), policy=label) for r, label in zip(results, labels)]
        comparisons = self.comparisons(results, labels) if self.compare else []
        if self.plot is not None:
            draw_results(self.plot, summaries)
        if self.json:
            print(json.dumps(self.content(results, summaries, comparisons, followed), indent=1))
        else:
            tables = [task_table(summary) for summary in summaries] + [protocol_table(summary) for summary in followed]
            tables += [overview_table(summaries)] if len(summaries) > 1 else []
            print("\n\n".join(table.text(self.markdown) for table in (*tables, *map(comparison_table, comparisons))))
        return 0

    def show_profiles(self, results: Sequence[Results], labels: Sequence[str]) -> int:
        """Print the profile of each file over its factors, and draw them."""
        from rlbench_pin.evaluation.results.plots import draw_profiles
        from rlbench_pin.evaluation.results.profile import factor_profile, profile_table

        if self.compare or not all(r.factors for r in results):
            raise TaskEnvironmentError("Files with factors are shown as profiles. Leave out --compare and files without factors.")
        profiles = [replace(factor_profile(r), policy=label) for r, label in zip(results, labels)]
        if self.plot is not None:
            draw_profiles(self.plot, profiles)
        if self.json:
            files = [
                {"file": str(path), "sha256": r.sha256, "commit": r.commit, "policy": profile.policy, **profile.as_dict()}
                for path, r, profile in zip(self.files, results, profiles)
            ]
            print(json.dumps({"format": 1, "profiles": files}, indent=1))
        else:
            print("\n\n".join(profile_table(profile).text(self.markdown) for profile in profiles))
        return 0

    def labels(self, results: Sequence[Results]) -> list[str]:
        """Return the label of each file: its policy; with the name of the file if two policies are equal."""
        names = [r.policy for r in results]
        for further in ([path.stem for path in self.files], [str(path) for path in self.files]):
            count = Counter(names)
            names = [f"{r.policy} ({more})" if count[n] > 1 else n for n, r, more in zip(names, results, further)]
        return names

    def comparisons(self, results: Sequence[Results], labels: Sequence[str]) -> list[Comparison]:
        """Compare every further file with the first."""
        from rlbench_pin.evaluation.results.comparison import compare

        found = []
        for other, label in zip(results[1:], labels[1:]):
            comparison = compare(
                results[0], other, np.random.default_rng(0),
                measure="stable" if self.stable else "success", common=self.common, any_limits=self.any_limits,
            )  # fmt: skip
            found.append(replace(comparison, first=labels[0], second=label))
        return found

    def content(
        self,
        results: Sequence[Results],
        summaries: Sequence[Summary],
        comparisons: Sequence[Comparison],
        followed: Sequence[ProtocolSummary],
    ) -> dict[str, Any]:
        """Return everything as plain data."""
        files = [
            {"file": str(path), "sha256": r.sha256, "commit": r.commit, **_summary(summary)}
            for path, r, summary in zip(self.files, results, summaries)
        ]
        for entry, protocol in zip(files, followed):
            entry["protocol"] = protocol.as_dict()
        return {"format": 1, "results": files, "comparisons": [_comparison(comparison) for comparison in comparisons]}


def _summary(summary: Summary) -> dict[str, Any]:
    tasks = [{**asdict(task), "success": task.success.as_dict(), "stable": task.stable.as_dict()} for task in summary.tasks]
    mean = {"success": summary.success.as_dict(), "stable": summary.stable.as_dict()}
    faults = [
        {"fault": e.fault, "task": e.task, "variation": e.variation, "seed": e.seed, "detail": e.fault_detail}
        for e in summary.first_faults
    ]
    return {"policy": summary.policy, "episodes": summary.episodes, "mean": mean, "tasks": tasks, "first_faults": faults}


def _comparison(comparison: Comparison) -> dict[str, Any]:
    tasks = [
        {"task": task.task, **asdict(task.pairs), **_tested(task.pairs.p), "p_holm": task.p_holm, "significant": task.significant}
        for task in comparison.tasks
    ]
    together = {**asdict(comparison.pairs), **_tested(comparison.pairs.p), "significant": comparison.significant}
    return {
        "first": comparison.first, "second": comparison.second, "measure": comparison.measure, "tasks": tasks, "all": together,
        "difference": comparison.difference.as_dict(), "remarks": list(comparison.remarks),
    }  # fmt: skip


def _tested(p: PValues) -> dict[str, float]:
    return {"p_exact": p.exact, "p_mid": p.mid}


@dataclass(frozen=True)
class VerifyResults:
    """Play a random sample of the episodes of a results file again, and compare them byte by byte with the file.

    Success, steps, time, contacts, refused actions and faults are compared. Exit code 1: an episode differs.
    """

    file: ResultsFile
    """Results file, as `rlbench-pin evaluate` writes it."""
    sample: Share = "5%"
    """Share of the episodes to play, drawn at random; at least one episode."""
    policy: PolicyName = ""
    """Policy, as for `evaluate`. Required unless the file names `noop`, `random` or `expert`: a file alone runs no code."""
    workers: int = 1
    """Number of worker processes, each with its own policy; 0 runs all in this process."""

    def run(self) -> int:
        """Print the episodes that differ; return 1 when there are any."""
        from rlbench_pin.cli.progress import EvaluationBar
        from rlbench_pin.evaluation.results.records import read_results
        from rlbench_pin.evaluation.run.verify import verify_results

        check_at_least(self, workers=0)
        share = self.share()
        results = read_results(self.file)
        engine = make_engine("processes", self.workers)
        with closing(EvaluationBar("verify")) as bar:
            found = verify_results(
                results, share, np.random.default_rng(), policy=self.policy, engine=engine, on_progress=bar
            )  # fmt: skip
        for difference in found.differences:
            print(_difference(difference))
        count = len(found.differences)
        outcome = f"{count or 'none'} of them differ{'s' * (count == 1)} from the file"
        print(f"{self.file}: {found.played} of {found.episodes} episodes played again, {outcome}.")
        for remark in found.remarks if count else ():
            print(remark)
        return 1 if count else 0

    def share(self) -> float:
        """Return the sample as a share, 0 to 1."""
        match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*%", self.sample.strip())
        if match is None or not 0.0 < float(match[1]) <= 100.0:
            raise TaskEnvironmentError(
                f"--sample is {self.sample}, which is not a share. Use a percentage above 0 and up to 100, such as 5%."
            )
        return float(match[1]) / 100.0


def _difference(difference: EpisodeDifference) -> str:
    """Return one line: the episode, and each field that differs with its value in the file and now."""
    from rlbench_pin.evaluation.results.tables import printable

    before, now = difference.recorded, difference.played
    fields = [f"{name} {getattr(before, name)} in the file, {getattr(now, name)} now" for name in difference.fields]
    with_factors = f" with {before.factors}" if before.factors else ""
    return printable(
        f"{before.task}, variation {before.variation}, seed {before.seed}{with_factors}: {'; '.join(fields)}", most=1000
    )
