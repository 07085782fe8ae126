"""Run the items of a check in one or several processes; a journal keeps finished items."""

from __future__ import annotations

import ast
import json
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from rlbench_pin.assets import ASSETS
from rlbench_pin.checking.plan import Item, Part
from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import RECORDS, Cost, FailedAttempt, SolvedDemo, Trial
from rlbench_pin.checking.trials import work
from rlbench_pin.checking.validate import NoopEpisode
from rlbench_pin.environment.demos import SegmentReport, library_versions
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.processes import GivenUp, Journal, ProcessEngine, SerialEngine, WorkerDeath, run_jobs
from rlbench_pin.tasks import LIBRARY, find_task
from rlbench_pin.tasks.registry import source_files
from rlbench_pin.urdf import read_urdf, solid_urdf
from rlbench_pin.values import as_function, as_names, as_path, as_record, as_several, as_whole

MAX_WORKERS = 1024
_PACKAGE = ASSETS.parent
_DECISIVE = ("reach.py", "records.py", "trials.py", "validate.py")
"""Files of this folder that trials depend on; the others only present results."""
_UNRELATED = tuple(
    _PACKAGE / folder
    for folder in (
        "assets/patterns", "assets/textures", "baselines", "builder", "cli", "compat", "datasets", "evaluation", "gym",
        "processes", "recording", "sim/render", "viewer",
    )
)  # fmt: skip
"""Folders of the package that trials do not depend on."""
_OBJECTS = ASSETS / "objects"
"""One folder for each object. Trials depend on the objects that the files of the task name."""
_NESTED: dict[str, type] = {"episode": NoopEpisode, "reach": Reach, "cost": Cost}
"""Field of a trial, or of its demonstration -> the class of its value."""
_LISTED: dict[str, type] = {"failed": FailedAttempt, "segments": SegmentReport}
"""Field -> the class of the elements of a tuple."""


@dataclass(frozen=True)
class CheckProgress:
    """Progress of a check."""

    total: int
    """Trials of the whole check."""
    found: int
    """Trials that the journal contained at the start."""
    done: int
    """Trials done now."""
    latest: Item | None = None
    """The last finished item, None at the start."""


def run_trials(
    items: Sequence[Item], workers: int, journal: TrialJournal, on_progress: Callable[[CheckProgress], None] | None = None
) -> list[Trial]:
    """Run the items that the journal does not contain yet, add them to it, and return the trials of all items.

    Args:
        items: The items.
        workers: Number of processes; the result does not depend on it.
        journal: The journal.
        on_progress: Called once before the work begins, and after each item.

    Raises:
        InvalidValue: An argument is wrong; no item was run.
        RlbenchPinError: Several workers died with the same item.
    """
    items = [as_record(item, Item, "an entry of items") for item in as_several(items, "items")]
    workers = as_whole(workers, "workers", least=1, most=MAX_WORKERS)
    as_record(journal, TrialJournal, "journal")
    as_function(on_progress, "on_progress")
    report = on_progress or (lambda _: None)
    found = {item: known for item in items if (known := journal.trials_of(item)) is not None}
    trials = [trial for item in items for trial in found.get(item, ())]
    todo = [item for item in items if item not in found]
    total = _count(items)
    progress = CheckProgress(total, total - _count(todo), 0)
    report(progress)
    engine = SerialEngine() if workers == 1 or len(todo) < 2 else ProcessEngine(workers)
    for event in run_jobs(todo, _Checker, store=lambda done: journal.add(*done), lost=_raise_lost, engine=engine):
        if isinstance(event, WorkerDeath):
            continue
        item, made = event
        trials += made
        progress = replace(progress, done=progress.done + len(item.seeds), latest=item)
        report(progress)
    return trials


class _Checker:
    """The worker of a check."""

    def make(self, item: Item) -> tuple[Item, list[Trial]]:
        return item, work(item)

    def close(self) -> None:
        """Do nothing: the worker keeps no resources between items."""


def _raise_lost(lost: GivenUp[Item]) -> tuple[Item, list[Trial]]:
    raise RlbenchPinError(
        f"Part '{lost.item.part}' of the check of '{lost.item.task}' failed: {lost.cause}. Check the free memory, or use fewer "
        "--workers. With --out, the same command continues from here."
    )


def _count(items: Sequence[Item]) -> int:
    return sum(len(item.seeds) for item in items)


class TrialJournal:
    """The finished items of a check: those in a file, and those added now.

    Args:
        path: File to read and to append to; None keeps no file.
        tasks: Tasks of the check: names, or paths of task files. A line is not used if the task, the package or its libraries
            changed after it was written.
    """

    def __init__(self, path: Path | None, tasks: Sequence[str]) -> None:
        path = None if path is None else as_path(path, "path")
        self._journal = None if path is None else Journal(path)
        self._marks = {} if path is None else task_marks(as_names(tasks, "tasks"))
        self._done: dict[str, list[Trial]] = {}
        for line in self._journal.lines if self._journal else ():
            try:
                self._done[line["key"]] = [as_trial(line["part"], trial) for trial in line["trials"]]  # type: ignore[index]
            except (ValueError, KeyError, TypeError):  # damaged, or of an earlier version: the item is done again
                continue

    def trials_of(self, item: Item) -> list[Trial] | None:
        """Return the trials of an item that was finished before, or None."""
        return self._done.get(self._key(item))

    def add(self, item: Item, trials: Sequence[Trial]) -> None:
        """Append a finished item to the file.

        Raises:
            StorageError: The disk cannot be written. Items that were added before are complete.
        """
        if self._journal is not None:
            plain = [asdict(trial) for trial in trials]
            self._journal.append({"key": self._key(item), "part": item.part, "trials": plain})

    def _key(self, item: Item) -> str:
        return json.dumps({**asdict(item), "mark": self._marks.get(item.task, "")}, sort_keys=True)


def as_trial(part: Part, plain: Mapping[str, Any]) -> Trial:
    """Return the trial of plain data from `dataclasses.asdict` and JSON.

    Args:
        part: Part of the check that it belongs to.
        plain: Its fields by name.

    Raises:
        KeyError: There is no such part.
        TypeError: These are not the fields of its record.
    """
    return RECORDS[part](**{name: _restored(name, value) for name, value in plain.items()})


def _restored(name: str, value: Any) -> Any:
    if value is None:
        return None
    if name == "demo":
        return SolvedDemo(**{inner: _restored(inner, content) for inner, content in value.items()})
    if name in _NESTED:
        return _NESTED[name](**{inner: _as_tuple(content) for inner, content in value.items()})
    if name in _LISTED:
        return tuple(_LISTED[name](**content) for content in value)
    return _as_tuple(value)


def _as_tuple(value: Any) -> Any:
    return tuple(map(_as_tuple, value)) if isinstance(value, list) else value


def task_marks(tasks: Sequence[str]) -> dict[str, str]:
    """Return task -> checksum of all files and library versions that its trials depend on."""
    marks = {}
    for task in as_names(tasks, "tasks"):
        mark, found = _package_mark().copy(), find_task(task)
        own, scene = source_files(found), found.scene_file()
        for file in (*own, *_named_objects(own), *_own_assets(scene)):
            _add(mark, file)
        marks[task] = mark.hexdigest()
    return marks


@cache
def _package_mark() -> Any:
    """Return the checksum of the libraries and of the package without its tasks and objects."""
    mark = sha256(json.dumps(library_versions()).encode())
    for file in sorted(_PACKAGE.rglob("*")):
        if file.is_file() and file.suffix not in (".pyc", ".md") and not {LIBRARY, _OBJECTS} & {*file.parents} and _decides(file):
            _add(mark, file)
    return mark


def _decides(file: Path) -> bool:
    if file.parent == _PACKAGE / "checking":
        return file.name in _DECISIVE
    return file == _PACKAGE / "datasets" / "key_frames.py" or not any(file.is_relative_to(folder) for folder in _UNRELATED)


def _named_objects(files: Sequence[Path]) -> list[Path]:
    """Return the files of the objects of the package that task files name. Visual meshes are included for markers only."""
    text, found = "".join(file.read_text() for file in files), []
    for folder in sorted(_OBJECTS.iterdir()):
        if f"objects/{folder.name}/" in text:
            for urdf in sorted(folder.glob("*.urdf")):
                solids = [shape for link in read_urdf(urdf).links for shape in link.collisions]
                found += [urdf, *sorted({shape.mesh for shape in solids if shape.mesh})] if solids else sorted(folder.iterdir())
    return found


def _is_solid(urdf: Path) -> bool:
    """Whether a model has collision shapes; without them its visual shapes count (`robot.geometry.solid_geometry`)."""
    return any(link.collisions for link in read_urdf(urdf).links)


def _own_assets(scene: Path) -> list[Path]:
    """Return the files next to a task outside the package that may be its assets."""
    if LIBRARY in scene.parents:
        return []
    return sorted(file for file in scene.parent.rglob("*") if file.suffix.lower() in (".urdf", ".obj", ".stl", ".dae", ".png"))


def _add(mark: Any, file: Path) -> None:
    mark.update(file.name.encode() + b"\0" + _content(file))


def _content(file: Path) -> bytes:
    """Return what trials depend on: code without comments and docstrings, scenes without notes, solid models without visuals."""
    if file.suffix == ".toml":
        scene = tomllib.loads(file.read_text(encoding="utf-8"))
        for body in scene.get("body", []):
            body.pop("role", None)
        notes = ("deviation", "excluded_factor")
        return json.dumps({table: value for table, value in scene.items() if table not in notes}).encode()
    if file.suffix == ".urdf" and _is_solid(file):
        return solid_urdf(file).encode()
    if file.suffix not in (".py", ".pyi"):
        return file.read_bytes()
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(body := getattr(node, "body", None), list):
            node.body = [part for part in body if not _is_text(part)]  # type: ignore[attr-defined]
    return ast.dump(tree).encode()


def _is_text(part: ast.AST) -> bool:
    return isinstance(part, ast.Expr) and isinstance(part.value, ast.Constant) and isinstance(part.value.value, str)
