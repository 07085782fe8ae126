"""`rlbench-pin check TASK...`: validate the contract of tasks and the success rate of their demonstrations."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tyro

from rlbench_pin.checking.plan import CheckPlan
from rlbench_pin.cli.list_tasks import ALL, named_tasks
from rlbench_pin.cli.options import (
    AnyTasks,
    Files,
    MaybePath,
    check_at_least,
    check_file,
    check_folder,
    checked_names,
    write_json,
    write_whole,
)
from rlbench_pin.errors import ResultsFileError, TaskEnvironmentError, storing

if TYPE_CHECKING:
    from rlbench_pin.checking import TaskReport, Trial, TrialJournal

FORMAT = 3


@dataclass(frozen=True)
class Check(CheckPlan):
    """Validate tasks: demonstrations succeed and can be replayed, resets repeat, the no-op and random policies do not succeed."""

    tasks: tyro.conf.Positional[AnyTasks] = ()
    """Task names, as `rlbench-pin list` prints them, or task files, separated by spaces or commas. Default: all tasks."""
    task_file: Files = ()
    """Task files outside the package, each with its scene file in the same folder."""
    workers: int = 1
    """Number of worker processes; the result does not depend on it."""
    explain: bool = False
    """Replay the first attempt of each cause of failure, print its evidence, and write an image of the world to the folder
    `explain` in `--out` (`out/explain` by default)."""
    json: MaybePath = None
    """JSON file for the whole report."""
    update: MaybePath = None
    """JSON report to update. Its tasks are kept where the numbers of trials, the task, the package and its libraries are
    unchanged. Other tasks are checked again if they are named, and removed otherwise."""
    out: MaybePath = None
    """Folder for the whole report: report.md with images, report.json, and trials.jsonl. With trials.jsonl, the same command
    continues after an interruption."""
    images: bool = True
    """With `--out`: also write a contact sheet and a reach map of each task."""

    def run(self) -> int:
        """Validate, print a table and the causes of failures; return 1 when a task fails."""
        from rlbench_pin.checking import run_trials
        from rlbench_pin.checking.page import table
        from rlbench_pin.cli.progress import CheckBar

        wanted = self._wanted()
        for file in filter(None, (self.json, self.update)):
            check_file(file)
        known = {} if self.update is None else self._known(self.update)
        wanted = {name: task for name, task in wanted.items() if name not in known}
        if self.out is not None:
            check_folder(self.out)
        with closing(CheckBar("check")) as bar:
            items = [item for task in wanted.values() for item in self.items(task)]
            trials = run_trials(items, self.workers, self._journal(wanted), bar)
        of_task = {name: [t for t in trials if t.task == name] for name in wanted}
        reports = [_report(name, wanted[name], of_task[name]) for name in wanted]
        print(table(reports))
        for report in reports:
            print_failures(report)
            if self.explain:
                self._explain(report, wanted[report.task])
        content = self._content(reports, wanted)
        if self.json is not None:
            write_json(self.json, content)
        if self.update is not None:
            content["tasks"] = dict(sorted((known | content["tasks"]).items()))
            write_json(self.update, content)
            print(f"{self.update}: {len(content['tasks'])} tasks, {len(known)} of them unchanged.")
        if self.out is not None:
            self._write(self.out, content, wanted, of_task)
        return 0 if all(task["passed"] for task in content["tasks"].values()) else 1

    def _wanted(self) -> dict[str, str]:
        """Return task name -> name or file, in the order of the report."""
        from rlbench_pin.tasks import find_task, task_reference

        from_none = dict.fromkeys(("replays", "key_frames", "friction_only", "seed", "unseen", "unseen_seed"), 0)
        check_at_least(self, episodes=1, variations=1, max_attempts=1, workers=1, **from_none)
        if self.contract:
            check_at_least(self, contract_seeds=1, placements=1)
        if self.unseen and self.seed - self.unseen < self.unseen_seed < self.seed + self.episodes:
            raise TaskEnvironmentError(
                f"Seeds {self.unseen_seed} to {self.unseen_seed + self.unseen - 1} would count twice: --episodes uses "
                f"{self.seed} to {self.seed + self.episodes - 1}. Choose another --unseen-seed."
            )
        missing = [str(path) for path in self.task_file if not path.is_file()]
        if missing:
            raise TaskEnvironmentError(
                f"There is no task file '{missing[0]}'. Check the path, or make a new task with `rlbench-pin new NAME`."
            )
        if self.tasks:
            asked = checked_names(self.tasks, named_tasks, "rlbench-pin check TASK...")
        else:
            asked = () if self.task_file else named_tasks((ALL,))
        named = {task.get_name(): task_reference(task) for task in map(find_task, asked)}
        return named | {find_task(str(path)).get_name(): str(path.resolve()) for path in self.task_file}

    def _journal(self, wanted: Mapping[str, str]) -> TrialJournal:
        from rlbench_pin.checking import TrialJournal

        return TrialJournal(None if self.out is None else self.out / "trials.jsonl", list(wanted.values()))

    def _known(self, file: Path) -> dict[str, Any]:
        """Return the tasks of a report that need no new check: name -> their part of it."""
        from rlbench_pin.checking import task_marks
        from rlbench_pin.tasks import library_names

        if not file.is_file():
            return {}
        try:
            content = json.loads(file.read_text(encoding="utf-8"))
            if any(content[name] != value for name, value in self._settings().items()):
                return {}
            marks = task_marks([name for name in content["tasks"] if name in library_names()])
            return {name: task for name, task in content["tasks"].items() if task.get("mark") == marks.get(name, "changed")}
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise ResultsFileError(
                file, "it is not a report of `rlbench-pin check`", "Name another file with --update."
            ) from error

    def _settings(self) -> dict[str, int]:
        settings = (
            "episodes", "replays", "seed", "unseen", "unseen_seed", "key_frames", "friction_only", "max_attempts",
            "contract_seeds", "placements",
        )  # fmt: skip
        return {"format": FORMAT, **{name: getattr(self, name) for name in settings}, "max_variations": self.variations}

    def _content(self, reports: Sequence[TaskReport], wanted: Mapping[str, str]) -> dict[str, Any]:
        from rlbench_pin.checking import task_marks
        from rlbench_pin.environment.demos import library_versions

        marks = task_marks(list(wanted.values()))
        tasks = {report.task: {"mark": marks[wanted[report.task]], **report.as_dict()} for report in reports}
        return {**self._settings(), "versions": library_versions(), "tasks": tasks}

    def _write(self, out: Path, content: dict[str, Any], wanted: Mapping[str, str], trials: Mapping[str, list[Trial]]) -> None:
        from rlbench_pin.checking.images import draw_images
        from rlbench_pin.checking.page import page

        write_json(out / "report.json", content)
        with storing(out):
            images = {name: draw_images(task, trials[name], out) for name, task in wanted.items()} if self.images else {}
        print(write_whole(out / "report.md", page(content, images).encode()))

    def _explain(self, report: TaskReport, task: str) -> None:
        """Replay failed attempts, one of each cause, and print their evidence."""
        from rlbench_pin.checking import explain_failure

        for f in report.failures:
            if f.part in ("demos", "unseen"):
                image = (self.out or Path("out")) / "explain" / f"{report.task}_{f.seed}_{f.attempt}.png"
                print("\n".join(explain_failure(task, f.seed, f.variation, image, attempt=f.attempt)))


def _report(name: str, task: str, trials: Sequence[Trial]) -> TaskReport:
    from rlbench_pin.checking import summarise
    from rlbench_pin.tasks import find_task

    chosen = find_task(task)
    return summarise(name, trials, chosen.solved_by_chance, chosen.variations_share_goals)


def print_failures(report: TaskReport) -> None:
    """Print the causes of failed attempts, most frequent first, each with an example seed."""
    for f in report.failures:
        where = "" if f.waypoint is None else f", waypoint {f.waypoint}"
        print(
            f"{report.task}: {f.count} x {f.cause}  (first at seed {f.seed}, variation {f.variation}, attempt {f.attempt}{where})"
        )
