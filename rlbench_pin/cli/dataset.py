"""`rlbench-pin dataset info|verify|merge|rerender|seeds|export`: inspect, check, copy and export stored demonstrations."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import asdict
from pathlib import Path

from tqdm import tqdm

from rlbench_pin.cli.arguments import dataset as arguments
from rlbench_pin.cli.list_tasks import split_names
from rlbench_pin.cli.process.commands import Subcommand
from rlbench_pin.cli.process.interrupts import INTERRUPTED
from rlbench_pin.cli.process.words import check_at_least, checked_names
from rlbench_pin.cli.progress import RecordBar, stopping_gently
from rlbench_pin.cli.record import make_engine, print_report
from rlbench_pin.datasets import TaskInfo, merge_datasets, plan_merge, read_manifest, stored_tasks, task_faults, task_info
from rlbench_pin.datasets.formats import export_dataset, stored_episodes
from rlbench_pin.errors import DatasetError, TaskEnvironmentError
from rlbench_pin.recording.config import PictureConfig
from rlbench_pin.recording.rerender import rerender, seeds_of, write_seeds
from rlbench_pin.tasks import own_tasks


class Info(arguments.Info):
    """The work of `rlbench-pin dataset info`."""

    def run(self) -> int:
        """Print one line per task."""
        infos = [task_info(self.root, task) for task in stored_tasks(self.root, at_least_one=True)]
        print(json.dumps([asdict(info) for info in infos], indent=1) if self.json else _table(infos))
        return 0


class Verify(arguments.Verify):
    """The work of `rlbench-pin dataset verify`."""

    def run(self) -> int:
        """Print what is wrong; 1 when something is."""
        bad = 0
        tasks = stored_tasks(self.root, at_least_one=True)
        for task in tqdm(tasks, unit="task", desc="verify"):
            for fault in task_faults(self.root, task, structure=not self.quick):
                bad += 1
                print(fault)
        episodes = 0 if bad else sum(len(read_manifest(self.root, task)) for task in tasks)
        if not bad and not episodes:
            raise _nothing_listed(self.root)
        print(f"{self.root}: {bad or 'no'} faults in {len(tasks)} tasks")
        return 1 if bad else 0


class Merge(arguments.Merge):
    """The work of `rlbench-pin dataset merge`."""

    def run(self) -> int:
        """Merge and print how many episodes were copied."""
        if not self.roots:
            raise TaskEnvironmentError("No dataset was named. Use `rlbench-pin dataset merge FOLDER... --out FOLDER`.")
        for root in self.roots:
            if not any(read_manifest(root, task) for task in stored_tasks(root, at_least_one=True)):
                raise _nothing_listed(root)
        with tqdm(total=len(plan_merge(self.roots, self.out)), unit="episode", desc="merge") as bar:
            moves = merge_datasets(self.roots, self.out, lambda _: bar.update() and None)
        print(f"{len(moves)} episodes copied to {self.out}")
        return 0


class Rerender(arguments.Rerender):
    """The work of `rlbench-pin dataset rerender`."""

    def run(self) -> int:
        """Rerender; 1 when episodes are missing at the end."""
        check_at_least(self, workers=0, image_size=1)
        pictures = PictureConfig(cameras=self.cameras, products=self.products, image_size=self.image_size)
        engine = make_engine(self.engine, self.workers)
        with stopping_gently() as stop, closing(RecordBar("rerender")) as bar:
            report = rerender(
                self.source,
                self.out,
                pictures,
                tasks=_tasks(self.tasks),
                engine=engine,
                on_progress=bar,
                stop=stop,
                own=own_tasks(self.task_file),
                trust_task_files=self.trust_task_files,
            )
        code = print_report(report, self.out, "the same command", as_json=False)
        return INTERRUPTED if code and stop.is_set() else code


class Seeds(arguments.Seeds):
    """The work of `rlbench-pin dataset seeds`."""

    def run(self) -> int:
        """Write and print how many."""
        seeds = seeds_of(self.root)
        if not seeds:
            raise _nothing_listed(self.root)
        print(f"{len(seeds)} seeds in {write_seeds(self.file, seeds)}")
        return 0


class Export(arguments.Export):
    """The work of `rlbench-pin dataset export`."""

    def run(self) -> int:
        """Export and say where it is."""
        tasks = _tasks(self.tasks)
        total = len(stored_episodes(self.root, tasks))
        with tqdm(total=total, unit="episode", desc=f"export {self.format}") as bar:
            export_dataset(
                self.format,
                self.root,
                self.out,
                tasks=tasks,
                cameras=self.cameras,
                on_episode=lambda _: bar.update() and None,
            )
        print(f"{total} episodes in {self.out}")
        return 0


class Dataset(arguments.Dataset):
    """The work of `rlbench-pin dataset`."""

    def run(self) -> int:
        """Do it."""
        assert isinstance(self.action, Subcommand)
        return self.action.run()


def _nothing_listed(root: Path) -> DatasetError:
    return DatasetError(f"'{root}' lists no episodes. `rlbench-pin record TASK --out {root}` makes some.")


def _tasks(words: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names in `words`, none when there are no words."""
    return checked_names(words, split_names, "--tasks TASK...") if words else ()


HEADER = ("task", "episodes", "variations", "frames", "lengths", "MB", "kB a frame", "retried", "pictures")


def _table(infos: list[TaskInfo]) -> str:
    rows = [HEADER, *map(_row, infos), _total(infos)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    table = "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)
    versions = {f"{name} {v}" for info in infos for name, vs in info.versions.items() for v in vs}
    return f"{table}\nmade with {', '.join(sorted(versions))}"


def _row(info: TaskInfo) -> tuple[str, ...]:
    sizes = sorted({"x".join(map(str, shape[1::-1])) for shape in info.pictures.values()})
    return (
        info.task,
        str(info.episodes),
        str(len(info.variations)),
        str(info.frames),
        f"{info.shortest}..{info.median:.0f}..{info.longest}",
        f"{info.num_bytes / 1e6:.1f}",
        f"{info.num_bytes / info.frames / 1e3:.1f}",
        str(info.retried),
        f"{len(info.pictures)} of {' '.join(sizes)} px" if info.pictures else "none",
    )


def _total(infos: list[TaskInfo]) -> tuple[str, ...]:
    frames, size = sum(i.frames for i in infos), sum(i.num_bytes for i in infos)
    numbers = (sum(i.episodes for i in infos), sum(len(i.variations) for i in infos), frames)
    return (
        "all",
        *map(str, numbers),
        "",
        f"{size / 1e6:.1f}",
        f"{size / frames / 1e3:.1f}",
        str(sum(i.retried for i in infos)),
        "",
    )
