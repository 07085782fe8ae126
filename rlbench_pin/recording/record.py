"""Recording of demonstrations by several workers.

Workers write no files. The process that calls `record` stores every episode completely before it adds it to the manifest. If that
process is killed, the dataset is consistent, and `resume` continues the recording.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from rlbench_pin.datasets import (
    DatasetWriter,
    EpisodeEntry,
    checked_task_name,
    encode_demo,
    episode_entry,
    fold_journal,
    read_demo,
    read_manifest,
    stored_tasks,
)
from rlbench_pin.datasets.layout import episode_path
from rlbench_pin.datasets.manifest import has_manifest
from rlbench_pin.datasets.reader import stored_images
from rlbench_pin.datasets.storage import hold, remove_leftovers
from rlbench_pin.environment.environment import Environment
from rlbench_pin.environment.task_environment import TaskEnvironment
from rlbench_pin.errors import DatasetConflict, EpisodeFileError, ResetError, RlbenchPinError, StorageError, TaskError
from rlbench_pin.observation import LOW_DIM, Demo
from rlbench_pin.processes import Engine, GivenUp, WorkerDeath, run_jobs
from rlbench_pin.recording.config import (
    RECORDING,
    ImageConfig,
    RecordConfig,
    WorkItem,
    all_flags,
    common_flags,
    plan_items,
    read_recording,
    write_recording,
)
from rlbench_pin.recording.replay import replay_demo
from rlbench_pin.sim import give_back_memory
from rlbench_pin.tasks import Task, chosen_tasks_of, find_task, is_task_file, keep_tasks, task_digest, task_reference, task_scene
from rlbench_pin.values import as_flag, as_function, as_path, as_record

_FREE_EVERY = 5_000_000
"""Bytes of episodes after which memory is freed."""


@dataclass(frozen=True)
class ItemResult:
    """The result of one work item."""

    item: WorkItem
    failures: tuple[str, ...]
    """Causes of failed attempts, each as `kind: message`."""
    data: bytes | None = None
    """The bytes of the episode file; None when all attempts failed."""
    entry: EpisodeEntry | None = None
    """Its line of the manifest."""


class Recorder:
    """Makes episodes, one after the other, in one environment for each arm.

    Args:
        config: Images of the episodes.
    """

    def __init__(self, config: ImageConfig) -> None:
        self.config = config
        self._environments: dict[str, Environment] = {}
        self._tasks: dict[str, TaskEnvironment] = {}
        self._loaded: tuple[str, tuple[float, float]] | None = None
        self._made = 0

    def make(self, item: WorkItem) -> ItemResult:
        """Make one episode; the result contains the causes of failed attempts."""
        failures: list[str] = []
        for attempt in item.attempts:
            try:
                demo = self._try(item, attempt, failures)
            except RlbenchPinError as error:
                failures.append(f"{type(error).__name__}: {error}")
                if not isinstance(error, ResetError):
                    break
                continue
            except Exception as error:  # a fault of one task must not cost the others
                failures.append(f"fault: {type(error).__name__}: {error}")
                self.close()
                continue
            if demo is not None:
                data = encode_demo(demo, self.config.compression)
                self._free_memory(len(data), after_failures=bool(failures))
                return ItemResult(item, tuple(failures), data, episode_entry(demo, data, item.index, failures))
        return ItemResult(item, tuple(failures))

    def close(self) -> None:
        """Free the environments; the next item makes others."""
        for environment in self._environments.values():
            environment.shutdown()
        self._environments, self._tasks, self._loaded = {}, {}, None

    def _free_memory(self, made: int, *, after_failures: bool) -> None:
        """Free memory after an episode with images, whose raw frames take tens of megabytes, or after many without.

        Only failed attempts leave frames in reference cycles, by their tracebacks; a full collection takes 70 ms.
        """
        self._made += made
        if self._made > _FREE_EVERY:
            self._made = 0
            give_back_memory(collect=after_failures)

    def _try(self, item: WorkItem, attempt: int, failures: list[str]) -> Demo | None:
        task = self._load(item, item.robot)
        fields = (*LOW_DIM, "gripper_matrix")
        stored = read_demo(Path(item.source), fields, sha256=item.sha256 or None) if item.source else None
        task.set_factors(item.factors if stored is None else stored.factors)
        outcome = task.try_demo(seed=item.seed, variation=item.variation, attempt=attempt, disturb=item.disturb)
        if stored is None:
            failures += [outcome.cause] if outcome.cause else []
            return outcome.demo if outcome.demo is None or self._all_can(item, attempt, failures) else None
        if outcome.demo is not None and same_motion(outcome.demo, stored):
            return outcome.demo
        return replay_demo(task, stored)

    def _all_can(self, item: WorkItem, attempt: int, failures: list[str]) -> bool:
        """Whether the paired arms demonstrate the attempt as well."""
        for robot in item.paired:
            task = self._load(item, robot)
            task.set_factors(item.factors)
            outcome = task.try_demo(seed=item.seed, variation=item.variation, attempt=attempt, record=False, disturb=item.disturb)
            if not outcome.success:
                failures.append(f"{robot}: {outcome.cause}")
                return False
        return True

    def _load(self, item: WorkItem, robot: str) -> TaskEnvironment:
        if self._loaded != (item.task, item.limits):
            if self._loaded is not None and self._loaded[1] != item.limits:
                self.close()
            self._tasks, self._loaded = {}, (item.task, item.limits)
        if robot not in self._environments:
            self._environments[robot] = self.config.environment(*item.limits, robot)
        if robot not in self._tasks:
            self._tasks[robot] = self._environments[robot].get_task(_task_of(item))
        return self._tasks[robot]


def _task_of(item: WorkItem) -> type[Task]:
    """Return the class of the task, unless its files have changed since the work was planned.

    Raises:
        TaskError: They have.
    """
    task = find_task(item.task)
    if item.task_digest and task_digest(task) != item.task_digest:
        raise TaskError(
            f"The files of the task '{item.name}' changed while it was recorded. Record it again into another folder."
        )
    return task


def same_motion(demo: Demo, other: Demo) -> bool:
    """Return whether two demonstrations have byte-identical joint positions in every frame."""
    joints, others = ([np.asarray(obs.joint_positions) for obs in d] for d in (demo, other))
    return len(joints) == len(others) and all(np.array_equal(a, b) for a, b in zip(joints, others))


@dataclass(frozen=True)
class RecordReport:
    """The result of a recording so far."""

    wanted: int
    """Number of episodes of the recording."""
    found: int
    """Number of episodes that were stored before this run."""
    recorded: int = 0
    """Number of episodes that this run has stored."""
    failed: tuple[ItemResult, ...] = ()
    """Episodes for which all attempts failed."""
    deaths: tuple[WorkerDeath[WorkItem], ...] = ()
    """Workers that died and were replaced."""
    causes: dict[str, int] = field(default_factory=dict)
    """Kind of failure -> number of attempts."""
    frames: int = 0
    """Number of frames that this run has stored."""
    num_bytes: int = 0
    """Number of bytes that this run has stored."""
    seconds: float = 0.0
    """Wall-clock time of this run [s]."""

    @property
    def missing(self) -> int:
        """Number of episodes that are not stored: they failed, or had not begun when the recording was stopped."""
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
    """Record demonstrations into a dataset folder, with a copy of the files of tasks that are not in the library.

    Args:
        config: Settings of the recording.
        root: Folder of the dataset; it is created if it does not exist.
        engine: The engine; None uses one process.
        resume: Continue the recording in the folder. When False, the folder must not contain episodes of these tasks.
        on_progress: Called with the report so far, first before the first episode.
        stop: When set, no further episode begins; running episodes are finished and stored.
        trust_task_files: Whether task files in the folder may be run, for named tasks that are not installed.

    Raises:
        DatasetConflict: The folder contains these tasks or another recording, a task file changed, or it is in use.
        UntrustedTaskFile: A task is code in the folder, and `trust_task_files` is not set.
        StorageError: The disk is full or cannot be written. Every episode stored before is complete.
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
        return run_items(config.images, items, root, engine=engine, on_progress=on_progress, stop=stop)


def check_work(engine: Engine | None, on_progress: OnProgress | None, stop: threading.Event | None, trust: bool) -> None:
    """Raise InvalidValue for wrong arguments, before any file is written."""
    if engine is not None:
        as_record(engine, Engine, "engine")  # type: ignore[type-abstract]
    if stop is not None:
        as_record(stop, threading.Event, "stop")
    as_function(on_progress, "on_progress")
    as_flag(trust, "trust_task_files")


def run_items(
    images: ImageConfig,
    items: Sequence[WorkItem],
    root: Path,
    *,
    engine: Engine | None = None,
    on_progress: OnProgress | None = None,
    stop: threading.Event | None = None,
) -> RecordReport:
    """Make and store the episodes that the folder does not contain yet."""
    watch = on_progress or (lambda report: None)
    began = time.perf_counter()
    pending = _pending(root, items)
    _check_images(root, items, {item.key for item in pending}, images)
    report = RecordReport(len(items), len(items) - len(pending))
    watch(report)
    writer = DatasetWriter(root)

    def store(result: ItemResult) -> None:
        if result.data is not None and result.entry is not None:
            writer.put(result.item.name, result.data, result.entry)

    try:
        for event in run_jobs(pending, partial(Recorder, images), store=store, lost=_lost, engine=engine, stop=stop):
            if isinstance(event, WorkerDeath):
                report = replace(report, deaths=(*report.deaths, event))
            else:
                report = report.with_result(event)
            report = replace(report, seconds=time.perf_counter() - began)
            watch(report)
    finally:
        _fold(root, {item.name for item in items})
    return report


def _lost(given_up: GivenUp[WorkItem]) -> ItemResult:
    return ItemResult(given_up.item, (given_up.cause,))


def _prepare(root: Path, config: RecordConfig, items: Sequence[WorkItem], tasks: Collection[type[Task]], resume: bool) -> None:
    names = {item.name for item in items}
    stored = sorted(names & set(stored_tasks(root)))
    if stored and not resume:
        raise DatasetConflict(f"'{root}' contains episodes of {stored} already. Use `--resume`, or choose another folder.")
    for task in tasks:
        _check_version(root, task)
    if (root / RECORDING).exists():
        before = read_recording(root)
        flags = common_flags if resume else all_flags
        then, now = flags(before), flags(config)
        if changed := [flag for flag in then if then[flag] != now[flag]]:
            recorded, given = (" ".join(f"{flag} {values[flag]}".strip() for flag in changed) for values in (then, now))
            raise DatasetConflict(
                f"'{root}' was recorded with `{recorded}`, not with `{given}`. Continue it without these flags: "
                f"`rlbench-pin record --resume --out {root}`. Or choose another folder."
            )
        config = replace(config, tasks=tuple(dict.fromkeys((*before.tasks, *config.tasks)))) if resume else config
    keep_tasks(root, tasks)
    write_recording(root, config)
    remove_leftovers(root)


def _check_version(root: Path, task: type[Task]) -> None:
    """Raise DatasetConflict if the folder contains episodes of another version of a task."""
    name, version = task.get_name(), task_scene(task).version
    stored = {entry.task_version for entry in read_manifest(root, name)} if has_manifest(root, name) else set()
    if stored - {version}:
        raise DatasetConflict(
            f"'{root}' contains episodes of version {min(stored - {version})} of '{name}', but the installed task has version "
            f"{version}. Choose another folder."
        )


def _pending(root: Path, items: Sequence[WorkItem]) -> list[WorkItem]:
    """Return the items that are not stored yet.

    Raises:
        DatasetConflict: Another episode is stored in place of an item.
    """
    listed: dict[tuple[str, int, int], EpisodeEntry] = {}
    for task in {item.name for item in items if has_manifest(root, item.name)}:
        listed.update({(task, e.variation, e.episode): e for e in read_manifest(root, task)})
    return [item for item in items if not _is_stored(root, item, listed.get(item.key))]


def _is_stored(root: Path, item: WorkItem, entry: EpisodeEntry | None) -> bool:
    if entry is None:
        return False
    path = episode_path(root, *item.key)
    if entry.random_seed != item.seed:
        raise DatasetConflict(f"'{path}' has the seed {entry.random_seed} instead of {item.seed}. Choose another folder.")
    return path.is_file() and path.stat().st_size == entry.num_bytes


def _check_images(root: Path, items: Sequence[WorkItem], pending: set[tuple[str, int, int]], images: ImageConfig) -> None:
    """Raise DatasetConflict when a stored episode of a task contains other images than the new ones would."""
    stored = {item.name: episode_path(root, *item.key) for item in items if item.key not in pending}
    for path in stored.values():
        with suppress(EpisodeFileError):  # damaged: `verify` finds it
            if (found := stored_images(path)) != images.fields():
                asked = images.fields()
                raise DatasetConflict(
                    f"'{path}' contains the images {found}, but the new episodes would contain {asked}. Use the same images, or "
                    "choose another folder."
                )


def _fold(root: Path, tasks: set[str]) -> None:
    for task in sorted(tasks):
        with suppress(StorageError):  # a full disk: the journal stays, and is read like the manifest
            fold_journal(root, checked_task_name(task))
