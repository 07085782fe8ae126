"""`rlbench-pin check TASK...`: does a task keep its contract, and how often does its demonstration succeed?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import fields
from pathlib import Path
from typing import Any

from rlbench_pin.checking import Item, TaskReport, Trial, TrialJournal, explain_failure, run_trials, summarise
from rlbench_pin.checking.images import draw_images
from rlbench_pin.checking.page import page, table
from rlbench_pin.checking.trials import CheckPlan
from rlbench_pin.cli.arguments import check as arguments
from rlbench_pin.cli.list_tasks import ALL, named_tasks
from rlbench_pin.cli.process.files import check_file, check_folder, storing, write_json, write_whole
from rlbench_pin.cli.process.words import check_at_least, checked_names
from rlbench_pin.cli.progress import CheckBar
from rlbench_pin.environment.demos import library_versions
from rlbench_pin.errors import TaskEnvironmentError
from rlbench_pin.tasks import find_task, task_reference

FORMAT = 3


class Check(arguments.Check):
    """The work of `rlbench-pin check`."""

    def run(self) -> int:
        """Judge, print a table and the causes of failures; 1 when a task fails."""
        wanted = self._wanted()
        if self.json is not None:
            check_file(self.json)
        if self.out is not None:
            check_folder(self.out)
        with closing(CheckBar()) as bar:
            trials = run_trials(list(self._items(wanted.values())), self.workers, self._journal(wanted), bar)
        of_task = {name: [t for t in trials if t.task == name] for name in wanted}
        reports = [_report(name, wanted[name], of_task[name]) for name in wanted]
        print(table(reports))
        for report in reports:
            print_failures(report)
            if self.explain:
                self._explain(report, wanted[report.task])
        content = self._content(reports)
        if self.json is not None:
            write_json(self.json, content)
        if self.out is not None:
            self._write(self.out, content, wanted, of_task)
        return 1 if any(report.faults for report in reports) else 0

    def _wanted(self) -> dict[str, str]:
        """Return task name -> name or file, in the order of the report."""
        check_at_least(
            self, episodes=1, variations=1, max_attempts=1, workers=1, replays=0, seed=0, unseen=0, unseen_seed=0, key_frames=0
        )
        if self.contract:
            check_at_least(self, contract_seeds=1, placements=1)
        if self.unseen and self.seed - self.unseen < self.unseen_seed < self.seed + self.episodes:
            raise TaskEnvironmentError(
                f"Seeds {self.unseen_seed} to {self.unseen_seed + self.unseen - 1} would count twice: --episodes uses "
                f"{self.seed} to {self.seed + self.episodes - 1}. Choose another --unseen-seed."
            )
        missing = [str(path) for path in self.task_file if not path.is_file()]
        if missing:
            raise TaskEnvironmentError(f"There is no task file '{missing[0]}'. `rlbench-pin new NAME` makes a pair of files.")
        if self.tasks:
            asked = checked_names(self.tasks, named_tasks, "rlbench-pin check TASK...")
        else:
            asked = () if self.task_file else named_tasks((ALL,))
        named = {task.get_name(): task_reference(task) for task in map(find_task, asked)}
        return named | {find_task(str(path)).get_name(): str(path.resolve()) for path in self.task_file}

    def _journal(self, wanted: Mapping[str, str]) -> TrialJournal:
        return TrialJournal(None if self.out is None else self.out / "trials.jsonl", list(wanted.values()))

    def _items(self, tasks: Iterable[str]) -> Iterator[Item]:
        plan = CheckPlan(**{field.name: getattr(self, field.name) for field in fields(CheckPlan)})
        for task in tasks:
            yield from plan.items(task)

    def _content(self, reports: Sequence[TaskReport]) -> dict[str, Any]:
        settings = (
            "episodes", "replays", "seed", "unseen", "unseen_seed", "key_frames", "max_attempts", "contract_seeds", "placements",
        )  # fmt: skip
        return {
            "format": FORMAT,
            **{name: getattr(self, name) for name in settings},
            "max_variations": self.variations,
            "versions": library_versions(),
            "tasks": {report.task: report.as_dict() for report in reports},
        }

    def _write(self, out: Path, content: dict[str, Any], wanted: Mapping[str, str], trials: Mapping[str, list[Trial]]) -> None:
        write_json(out / "report.json", content)
        with storing(out):
            pictures = {name: draw_images(task, trials[name], out) for name, task in wanted.items()} if self.pictures else {}
        print(write_whole(out / "report.md", page(content, pictures).encode()))

    def _explain(self, report: TaskReport, task: str) -> None:
        """Play failed tries again, one of each cause, and print what is known of them."""
        for f in report.failures:
            if f.part in ("demos", "unseen"):
                picture = (self.out or Path("out")) / "explain" / f"{report.task}_{f.seed}_{f.attempt}.png"
                print("\n".join(explain_failure(task, f.seed, f.variation, picture, attempt=f.attempt)))


def _report(name: str, task: str, trials: Sequence[Trial]) -> TaskReport:
    chosen = find_task(task)
    return summarise(name, trials, chosen.solved_by_chance, chosen.variations_share_goals)


def print_failures(report: TaskReport) -> None:
    """Print why tries failed, most frequent first, with a seed to see it."""
    for f in report.failures:
        where = "" if f.waypoint is None else f", waypoint {f.waypoint}"
        print(
            f"{report.task}: {f.count} x {f.cause}  (first at seed {f.seed}, variation {f.variation}, attempt {f.attempt}{where})"
        )
