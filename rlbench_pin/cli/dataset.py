"""`rlbench-pin dataset info|verify|merge|rerender|seeds|export`: inspect, check, copy and export stored demonstrations."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from rlbench_pin.cli.interrupts import INTERRUPTED
from rlbench_pin.cli.list_tasks import split_names
from rlbench_pin.cli.options import (
    Cameras,
    EngineName,
    ExportFormat,
    Files,
    OnlyCameras,
    OnlyTasks,
    Products,
    Size,
    SomeFolders,
    check_at_least,
    checked_names,
)
from rlbench_pin.cli.record import make_engine, print_report
from rlbench_pin.errors import DatasetError, TaskEnvironmentError
from rlbench_pin.observation import CAMERAS

if TYPE_CHECKING:
    from rlbench_pin.datasets import TaskInfo

Root = tyro.conf.Positional[Annotated[Path, tyro.conf.arg(metavar="FOLDER")]]
HEADER = ("task", "episodes", "variations", "frames", "lengths", "MB", "kB a frame", "retried", "images")


@dataclass(frozen=True)
class Info:
    """Print the numbers of episodes, frames, bytes and retries, and the versions."""

    root: Root
    """Folder of the dataset."""
    json: bool = False
    """Print JSON for programs."""

    def run(self) -> int:
        """Print one line per task."""
        from rlbench_pin.datasets import stored_tasks, task_info

        infos = [task_info(self.root, task) for task in stored_tasks(self.root, at_least_one=True)]
        print(json.dumps([asdict(info) for info in infos], indent=1) if self.json else _table(infos))
        return 0


@dataclass(frozen=True)
class Verify:
    """Check every file against its SHA-256, read every value, and print the damaged files."""

    root: Root
    """Folder of the dataset."""
    quick: bool = False
    """Only compare checksums."""

    def run(self) -> int:
        """Print the faults; return 1 when there are any."""
        from rlbench_pin.cli.bars import progress_bar
        from rlbench_pin.datasets import read_manifest, stored_tasks, task_faults

        bad = 0
        tasks = stored_tasks(self.root, at_least_one=True)
        for task in progress_bar(tasks, unit="task", desc="verify"):
            for fault in task_faults(self.root, task, structure=not self.quick):
                bad += 1
                print(fault)
        episodes = 0 if bad else sum(len(read_manifest(self.root, task)) for task in tasks)
        if not bad and not episodes:
            raise _nothing_listed(self.root)
        print(f"{self.root}: {bad or 'no'} faults in {len(tasks)} tasks")
        return 1 if bad else 0


@dataclass(frozen=True)
class Merge:
    """Copy the episodes of several datasets into one; incompatible datasets are refused before anything is written."""

    out: Path
    """Folder of the result; it may contain episodes already."""
    roots: tyro.conf.Positional[SomeFolders] = ()
    """Folders of the datasets."""

    def run(self) -> int:
        """Merge and print how many episodes were copied."""
        from rlbench_pin.cli.bars import progress_bar
        from rlbench_pin.datasets import merge_datasets, plan_merge, read_manifest, stored_tasks

        if not self.roots:
            raise TaskEnvironmentError("No dataset was named. Use `rlbench-pin dataset merge FOLDER... --out FOLDER`.")
        for root in self.roots:
            if not any(read_manifest(root, task) for task in stored_tasks(root, at_least_one=True)):
                raise _nothing_listed(root)
        with progress_bar(total=len(plan_merge(self.roots, self.out)), unit="episode", desc="merge") as bar:
            moves = merge_datasets(self.roots, self.out, lambda _: bar.update() and None)
        print(f"{len(moves)} episodes copied to {self.out}")
        return 0


@dataclass(frozen=True)
class Rerender:
    """Record demonstrations again from their seeds or their states, with other cameras, sizes and products."""

    source: Root
    """Folder of the dataset (its manifests are enough), or a file with a list of seeds."""
    out: Path
    """Folder of the result. The same command continues an interrupted run."""
    tasks: OnlyTasks = ()
    """Only these tasks, separated by spaces or commas."""
    image_size: Size = (128, 128)
    """Width and height of the images [px]."""
    cameras: Cameras = CAMERAS
    """Cameras whose images are stored."""
    products: Products = ("rgb", "depth", "mask")
    """Images of each camera: rgb, depth, mask, point_cloud."""
    workers: int = 1
    """Number of worker processes; 0 runs all in this process."""
    engine: EngineName = "processes"
    """Engine: processes of this machine, or a Ray cluster."""
    task_file: Files = ()
    """Your own task files for tasks that are not installed; they replace those in the dataset."""
    trust_task_files: bool = False
    """Run the task files in the dataset, for tasks that are not installed. Read them first."""

    def run(self) -> int:
        """Rerender; return 1 when episodes are missing at the end."""
        from rlbench_pin.cli.progress import RecordBar, stopping_gently
        from rlbench_pin.recording.config import ImageConfig
        from rlbench_pin.recording.rerender import rerender
        from rlbench_pin.tasks import own_tasks

        check_at_least(self, workers=0, image_size=1)
        images = ImageConfig(cameras=self.cameras, products=self.products, image_size=self.image_size)
        engine = make_engine(self.engine, self.workers)
        with stopping_gently() as stop, closing(RecordBar("rerender")) as bar:
            report = rerender(
                self.source,
                self.out,
                images,
                tasks=_tasks(self.tasks),
                engine=engine,
                on_progress=bar,
                stop=stop,
                own=own_tasks(self.task_file),
                trust_task_files=self.trust_task_files,
            )
        code = print_report(report, self.out, "the same command", as_json=False)
        return INTERRUPTED if code and stop.is_set() else code


@dataclass(frozen=True)
class Seeds:
    """Write the seeds of a dataset to a small file, from which `rerender` reproduces it."""

    root: Root
    """Folder of the dataset."""
    file: tyro.conf.Positional[Path]
    """The file to write."""

    def run(self) -> int:
        """Write the file, and print the number of seeds."""
        from rlbench_pin.recording.rerender import seeds_of, write_seeds

        seeds = seeds_of(self.root)
        if not seeds:
            raise _nothing_listed(self.root)
        print(f"{len(seeds)} seeds in {write_seeds(self.file, seeds)}")
        return 0


@dataclass(frozen=True)
class Export:
    """Write a dataset in the format of another library."""

    format: tyro.conf.Positional[ExportFormat]
    """`lerobot` (LeRobotDataset v3), `robomimic` (one HDF5 file), `rlbench` or `peract` (folders of PNG files), `zarr`."""
    root: Root
    """Folder of the dataset."""
    out: tyro.conf.Positional[Path]
    """The new folder or file."""
    tasks: OnlyTasks = ()
    """Only these tasks, separated by spaces or commas."""
    cameras: OnlyCameras = ()
    """Cameras whose images are exported. Default: all stored cameras. `rlbench` and `peract` always export all."""

    def run(self) -> int:
        """Export, and print the number of episodes and the path."""
        from rlbench_pin.cli.bars import progress_bar
        from rlbench_pin.datasets.formats import export_dataset, stored_episodes

        tasks = _tasks(self.tasks)
        total = len(stored_episodes(self.root, tasks))
        with progress_bar(total=total, unit="episode", desc=f"export {self.format}") as bar:
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


@dataclass(frozen=True)
class Dataset:
    """Inspect, verify, merge, rerender and export stored demonstrations."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Info, tyro.conf.subcommand("info")]
        | Annotated[Verify, tyro.conf.subcommand("verify")]
        | Annotated[Merge, tyro.conf.subcommand("merge")]
        | Annotated[Rerender, tyro.conf.subcommand("rerender")]
        | Annotated[Seeds, tyro.conf.subcommand("seeds")]
        | Annotated[Export, tyro.conf.subcommand("export")]
    ] = field()
    """Subcommand."""

    def run(self) -> int:
        """Run the subcommand."""
        return self.action.run()


def _nothing_listed(root: Path) -> DatasetError:
    return DatasetError(f"'{root}' lists no episodes. `rlbench-pin record TASK --out {root}` makes some.")


def _tasks(words: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names in `words`, none when there are no words."""
    return checked_names(words, split_names, "--tasks TASK...") if words else ()


def _table(infos: list[TaskInfo]) -> str:
    rows = [HEADER, *map(_row, infos), _total(infos)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    table = "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)
    versions = {f"{name} {v}" for info in infos for name, vs in info.versions.items() for v in vs}
    return f"{table}\nmade with {', '.join(sorted(versions))}"


def _row(info: TaskInfo) -> tuple[str, ...]:
    sizes = sorted({"x".join(map(str, shape[1::-1])) for shape in info.images.values()})
    return (
        info.task,
        str(info.episodes),
        str(len(info.variations)),
        str(info.frames),
        f"{info.shortest}..{info.median:.0f}..{info.longest}",
        f"{info.num_bytes / 1e6:.1f}",
        f"{info.num_bytes / info.frames / 1e3:.1f}",
        str(info.retried),
        f"{len(info.images)} of {' '.join(sizes)} px" if info.images else "none",
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
