"""Finished work of a check on disk, one JSON line for each item, so that a killed check goes on where it stopped."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

from rlbench_pin.assets import ASSETS
from rlbench_pin.checking.judge import Rest
from rlbench_pin.checking.reach import Reach
from rlbench_pin.checking.records import RECORDS, Cost, FailedAttempt, Part, SolvedDemo, Trial
from rlbench_pin.checking.trials import Item
from rlbench_pin.datasets.storage import storing
from rlbench_pin.environment.demos import SegmentReport, library_versions
from rlbench_pin.tasks import LIBRARY, find_task
from rlbench_pin.values import as_names, as_path

_PACKAGE = ASSETS.parent
_DECISIVE = ("judge.py", "reach.py", "records.py", "stopwatch.py", "trials.py")
"""Files of this folder that trials depend on; the others only show them."""
_UNRELATED = ("cli", "datasets", "evaluation", "gym", "recording")
"""Folders of the package that trials do not depend on."""
_NESTED: dict[str, type] = {"rest": Rest, "reach": Reach, "cost": Cost}
"""Field of a trial, or of its demonstration -> the record that it holds."""
_LISTED: dict[str, type] = {"failed": FailedAttempt, "segments": SegmentReport}
"""Field -> the record of which it holds a tuple."""


class TrialJournal:
    """What was done before, and what is added now.

    Args:
        path: File to read and to append to; None keeps nothing.
        tasks: Tasks of the check: names, or paths of task files. What was written before they, the package or its libraries
            changed is not used.
    """

    def __init__(self, path: Path | None, tasks: Sequence[str]) -> None:
        path = None if path is None else as_path(path, "path")
        self._path = path
        self._marks = {} if path is None else _marks(as_names(tasks, "tasks"))
        self._done: dict[str, list[Trial]] = {}
        if path is not None and path.is_file():
            self._read(path)

    def trials_of(self, item: Item) -> list[Trial] | None:
        """Return the trials of an item that was done before, or None."""
        return self._done.get(self._key(item))

    def add(self, item: Item, trials: Sequence[Trial]) -> None:
        """Append a finished item to the file.

        Raises:
            StorageError: The disk cannot be written to. What was added before is whole.
        """
        if self._path is None:
            return
        entry = {"key": self._key(item), "part": item.part, "trials": [asdict(trial) for trial in trials]}
        with storing(self._path):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(entry) + "\n")

    def _key(self, item: Item) -> str:
        return json.dumps({**asdict(item), "mark": self._marks.get(item.task, "")}, sort_keys=True)

    def _read(self, path: Path) -> None:
        text = path.read_text(encoding="utf-8")
        if text and not text.endswith("\n"):  # killed while writing
            with storing(path):
                path.write_text(text[: text.rfind("\n") + 1], encoding="utf-8")
        for line in text.splitlines():
            try:
                entry = json.loads(line)
                self._done[entry["key"]] = [as_trial(entry["part"], trial) for trial in entry["trials"]]
            except (ValueError, KeyError, TypeError):  # damaged, or of an earlier version: the item is done again
                continue


def as_trial(part: Part, plain: Mapping[str, Any]) -> Trial:
    """Return the trial that `dataclasses.asdict` and JSON made plain.

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


def _marks(tasks: Sequence[str]) -> dict[str, str]:
    """Return task -> a checksum of everything that its trials depend on."""
    shared = sha256(json.dumps(library_versions()).encode())
    for file in sorted(_PACKAGE.rglob("*")):
        if file.is_file() and file.suffix != ".pyc" and LIBRARY not in file.parents and _decides(file):
            _add(shared, file)
    marks = {}
    for task in tasks:
        mark, chosen = shared.copy(), find_task(task)
        scene = chosen.scene_file()
        for file in (scene.with_suffix(".py"), scene, *_own_assets(scene)):
            _add(mark, file)
        marks[task] = mark.hexdigest()
    return marks


def _decides(file: Path) -> bool:
    folder = file.relative_to(_PACKAGE).parts[0]
    return file.name in _DECISIVE if folder == "checking" else folder not in _UNRELATED


def _own_assets(scene: Path) -> list[Path]:
    """Return the files of a task outside the package that may hold its assets."""
    if LIBRARY in scene.parents:
        return []
    return sorted(file for file in scene.parent.rglob("*") if file.suffix.lower() in (".urdf", ".obj", ".stl", ".dae", ".png"))


def _add(mark: Any, file: Path) -> None:
    mark.update(file.name.encode() + b"\0" + file.read_bytes())
