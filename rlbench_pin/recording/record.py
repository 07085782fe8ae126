"""Recording demonstrations by the thousand: plan the work, give it to an engine, store what comes back, lose nothing.

Workers write nothing. The one process that calls `record` stores every episode whole before it lists it, so whatever is
killed, and whenever, the dataset is consistent and `resume` goes on where it ended.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from rlbench_pin.datasets import DatasetWriter, EpisodeEntry, checked_task_name, fold_journal, read_manifest, stored_tasks
from rlbench_pin.datasets.layout import episode_path
from rlbench_pin.datasets.reader import stored_pictures
from rlbench_pin.datasets.storage import hold, remove_leftovers
from rlbench_pin.errors import DatasetConflict, EpisodeFileError, StorageError
from rlbench_pin.processes import Engine, GivenUp, ProcessEngine, WorkerDeath
from rlbench_pin.recording.config import PictureConfig, RecordConfig, WorkItem, plan_items
from rlbench_pin.recording.settings_file import RECORDING, read_recording, write_recording
from rlbench_pin.recording.work import ItemResult, Recorder
from rlbench_pin.tasks import Task, chosen_tasks_of, is_task_file, keep_tasks, task_reference
from rlbench_pin.values import as_flag, as_function, as_path, as_record


@dataclass(frozen=True)
class RecordReport:
    """The result of a recording so far."""

    wanted: int
    """Episodes asked for."""
    found: int
    """Of these, stored before."""
    recorded: int = 0
    """Of these, stored now."""
    failed: tuple[ItemResult, ...] = ()
    """Episodes of which every try failed."""
    deaths: tuple[WorkerDeath[WorkItem], ...] = ()
    """Workers that died and were replaced."""
    causes: dict[str, int] = field(default_factory=dict)
    """Kind of failure -> tries that failed so."""
    frames: int = 0
    """Frames stored now."""
    num_bytes: int = 0
    """Bytes stored now."""
    seconds: float = 0.0
    """Time it took [s]."""

    @property
    def missing(self) -> int:
        """Episodes that are not stored: failed, or not begun when the recording was stopped."""
        return self.wanted - self.found - self.recorded

    def with_result(self, result: ItemResult) -> RecordReport:
        """Return the report with one more result."""
        causes = Counter(self.causes)
        causes.update(failure.split(":")[0] for failure in result.failures)
        report = replace(self, causes=dict(causes))
        if result.entry is None:
            return replace(report, failed=(*self.failed, result))
        frames, size = self.frames + result.entry.frames, self.num_bytes + result.entry.num_bytes
        return replace(report, recorded=self.recorded + 1, frames=frames, num_bytes=size)


OnProgress = Callable[[RecordReport], None]
"""Called with the report so far."""


def record(
    config: RecordConfig,
    root: Path | str,
    *,
    engine: Engine | None = None,
    resume: bool = False,
    on_progress: OnProgress | None = None,
    stop: threading.Event | None = None,
    trust_task_files: bool = False,
) -> RecordReport:
    """Record demonstrations into a dataset folder, which keeps a copy of the files of tasks that are not in the library.

    Args:
        config: Which demonstrations.
        root: Folder of the dataset, created when missing.
        engine: Who does the work; one process when None.
        resume: Go on with what the folder holds; otherwise it must not hold these tasks yet.
        on_progress: Called with the report so far, first before anything was made.
        stop: When set, nothing more is begun; what is under way is finished and stored.
        trust_task_files: Whether task files that the folder keeps may be run, for tasks that are named and not installed.

    Raises:
        DatasetConflict: The folder holds these tasks, or another recording, or a task file changed, or it is being written to.
        UntrustedTaskFile: A task is code that came with the folder, and nobody said that it may be run.
        StorageError: The disk is full or cannot be written. Every episode stored before is whole.
        UnknownName: A task does not exist.
    """
    root, config = as_path(root, "root"), as_record(config, RecordConfig, "config")
    as_flag(resume, "resume")
    check_work(engine, on_progress, stop, trust_task_files)
    tasks = chosen_tasks_of(root, config.tasks, trust_task_files)
    references = {task_reference(task) if is_task_file(task) else word: task for word, task in tasks.items()}
    items = plan_items(config, references)
    names = tuple(task.get_name() if is_task_file(task) else word for word, task in tasks.items())
    with hold(root):
        _prepare(root, replace(config, tasks=names), items, tasks.values(), resume)
        return run_items(config.pictures, items, root, engine=engine, on_progress=on_progress, stop=stop)


def check_work(engine: Engine | None, on_progress: OnProgress | None, stop: threading.Event | None, trust: bool) -> None:
    """Raise InvalidValue for what cannot do work, be told of it, or end it, before a folder is touched."""
    if engine is not None:
        as_record(engine, Engine, "engine")  # type: ignore[type-abstract]
    if stop is not None:
        as_record(stop, threading.Event, "stop")
    as_function(on_progress, "on_progress")
    as_flag(trust, "trust_task_files")


def run_items(
    pictures: PictureConfig,
    items: Sequence[WorkItem],
    root: Path,
    *,
    engine: Engine | None = None,
    on_progress: OnProgress | None = None,
    stop: threading.Event | None = None,
) -> RecordReport:
    """Do the pieces of work that the folder does not hold yet and store what comes of them."""
    watch = on_progress or (lambda report: None)
    stop = stop or threading.Event()
    began = time.perf_counter()
    pending = _pending(root, items)
    _check_pictures(root, items, {item.key for item in pending}, pictures)
    report = RecordReport(len(items), len(items) - len(pending))
    watch(report)
    writer = DatasetWriter(root)
    try:
        with closing((engine or ProcessEngine()).map(partial(Recorder, pictures), pending, stop)) as events:
            for event in events:
                if isinstance(event, WorkerDeath):
                    report = replace(report, deaths=(*report.deaths, event))
                else:
                    result = ItemResult(event.item, (event.cause,)) if isinstance(event, GivenUp) else event
                    if result.data is not None and result.entry is not None:
                        writer.put(result.item.name, result.data, result.entry)
                    report = report.with_result(result)
                report = replace(report, seconds=time.perf_counter() - began)
                watch(report)
    finally:
        _fold(root, {item.name for item in items})
    return report


def _prepare(root: Path, config: RecordConfig, items: Sequence[WorkItem], tasks: Collection[type[Task]], resume: bool) -> None:
    names = {item.name for item in items}
    held = sorted(names & set(stored_tasks(root)))
    if held and not resume:
        raise DatasetConflict(f"'{root}' holds episodes of {held} already. Go on with `--resume`, or choose another folder.")
    if (root / RECORDING).exists():
        before = read_recording(root)
        for name in ("seed", "max_attempts", "pictures"):
            then, now = getattr(before, name), getattr(config, name)
            if held and then != now:
                raise DatasetConflict(
                    f"'{root}' was recorded with {name}={then}, this is {name}={now}. Use the same, or choose another folder."
                )
        config = replace(config, tasks=tuple(dict.fromkeys((*before.tasks, *config.tasks)))) if resume else config
    keep_tasks(root, tasks)
    write_recording(root, config)
    remove_leftovers(root)


def _pending(root: Path, items: Sequence[WorkItem]) -> list[WorkItem]:
    """Return what is not stored yet.

    Raises:
        DatasetConflict: Another episode lies where one belongs.
    """
    listed: dict[tuple[str, int, int], EpisodeEntry] = {}
    for task in {item.name for item in items}:
        listed.update({(task, e.variation, e.episode): e for e in read_manifest(root, task)})
    return [item for item in items if not _is_stored(root, item, listed.get(item.key))]


def _is_stored(root: Path, item: WorkItem, entry: EpisodeEntry | None) -> bool:
    if entry is None:
        return False
    path = episode_path(root, *item.key)
    if entry.random_seed != item.seed:
        raise DatasetConflict(f"'{path}' shows seed {entry.random_seed}, but {item.seed} belongs there. Choose another folder.")
    return path.is_file() and path.stat().st_size == entry.num_bytes


def _check_pictures(root: Path, items: Sequence[WorkItem], pending: set[tuple[str, int, int]], pictures: PictureConfig) -> None:
    """Raise DatasetConflict when a stored episode of a task holds other pictures than the new ones would."""
    stored = {item.name: episode_path(root, *item.key) for item in items if item.key not in pending}
    for path in stored.values():
        with suppress(EpisodeFileError):  # damaged: `verify` finds it
            if (found := stored_pictures(path)) != pictures.fields():
                asked = pictures.fields()
                raise DatasetConflict(
                    f"'{path}' holds the pictures {found}, asked for are {asked}. Choose the same, or another folder."
                )


def _fold(root: Path, tasks: set[str]) -> None:
    for task in sorted(tasks):
        with suppress(StorageError):  # a full disk: the journal stays, and is read like the manifest
            fold_journal(root, checked_task_name(task))
