"""Copies of the files of a user's task, stored with its episodes in `<root>/<task>/task_file/`, each with its SHA-256.

They are code and run only if the user allows it.
"""

from __future__ import annotations

import json
import os.path
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from rlbench_pin.datasets.layout import checked_task_name
from rlbench_pin.datasets.manifest import digest, file_digest
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.errors import DatasetConflict, DatasetError, EpisodeFileError
from rlbench_pin.values import as_path, as_record, as_text

FOLDER = "task_file"
_INDEX = "files.json"
_VERSION = 1
_MAX_INDEX = 1 << 20
"""So many bytes an index may have at most."""


@dataclass(frozen=True)
class KeptTask:
    """The stored files of one task in a dataset."""

    task: str
    """Task name."""
    folder: Path
    """Where they are."""
    file: str
    """Which of them is the Python file."""
    files: dict[str, str]
    """Path below the folder -> SHA-256."""

    @property
    def path(self) -> Path:
        """The Python file."""
        return self.folder / self.file

    def contents(self) -> dict[str, bytes]:
        """Read and check all files.

        Raises:
            EpisodeFileError: A file is missing, outside of the folder, or differs from its SHA-256.
        """
        return {name: self._checked(name) for name in self.files}

    def _checked(self, name: str) -> bytes:
        path = self.folder / name
        if not path.is_file() or not path.resolve().is_relative_to(self.folder.resolve()):
            raise EpisodeFileError(
                path, f"'{path}' is listed in '{self.folder / _INDEX}' but is not a file of that folder. Restore it."
            )
        data = path.read_bytes()
        if digest(data) != self.files[name]:
            raise EpisodeFileError(path, f"'{path}' is not the stored file: the SHA-256 differs. Do not run it; restore it.")
        return data


def kept_task(root: Path, task: str) -> KeptTask | None:
    """Return the stored files of a task, unread; None if there are none.

    Raises:
        EpisodeFileError: The list of files is damaged, or names files outside of its folder.
    """
    folder = as_path(root, "root") / checked_task_name(task) / FOLDER
    index = folder / _INDEX
    if not os.path.isfile(index):  # no also where nothing can be looked up: whoever writes there finds out why
        return None
    try:
        if index.stat().st_size > _MAX_INDEX:
            raise ValueError("it is too long")
        content = json.loads(index.read_text(encoding="utf-8"))
        if content["version"] != _VERSION:
            raise ValueError(f"it has version {content['version']!r}, this package reads version {_VERSION}")
        kept = KeptTask(content["task"], folder, content["file"], dict(content["files"]))
        fault = _fault(kept, task)
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        fault = f"{type(error).__name__}: {error}"
    if fault:
        raise EpisodeFileError(index, f"'{index}' does not list the files of the task '{task}': {fault}. Restore it.")
    return kept


def keep_files(root: Path, task: str, file: str, contents: Mapping[str, bytes]) -> KeptTask:
    """Store the files of a task in a dataset; do nothing if the same files are stored.

    Args:
        root: Folder of the dataset.
        task: Task name.
        file: Name of the Python file.
        contents: Path relative to the folder of that file, with slashes -> bytes.

    Raises:
        DatasetConflict: Other files are stored there.
        StorageError: The disk cannot be written to.
    """
    as_text(file, "file")
    for name, content in as_record(contents, Mapping, "contents").items():  # type: ignore[type-abstract]
        as_record(content, bytes, f"the content of {as_text(name, 'the name of a file')}")
    kept = KeptTask(
        task, as_path(root, "root") / checked_task_name(task) / FOLDER, file, {n: digest(d) for n, d in contents.items()}
    )
    before = kept_task(root, task)
    if before is not None:
        check_same(before, kept.files, f"'{file}', which is to be recorded")
        if all((before.folder / n).is_file() and file_digest(before.folder / n) == s for n, s in before.files.items()):
            return before
    for name, data in sorted(contents.items()):
        write_whole(kept.folder / name, data)
    index = {"version": _VERSION, "task": task, "file": file, "files": dict(sorted(kept.files.items()))}
    write_whole(kept.folder / _INDEX, (json.dumps(index, indent=1) + "\n").encode())
    return kept


def check_same(kept: KeptTask, files: Mapping[str, str], other: str) -> None:
    """Raise DatasetConflict if the files of a task differ from the stored ones."""
    names = sorted(name for name in {*kept.files, *files} if kept.files.get(name) != files.get(name))
    if names:
        raise DatasetConflict(
            f"The episodes of '{kept.task}' were made with the task files in '{kept.folder}'; in {other}, {names} differ. "
            "Use those files, or another folder for the changed task."
        )


def check_alike(roots: Sequence[Path], task: str) -> None:
    """Raise DatasetConflict unless all datasets store the same files of a task, or none stores any."""
    kept = [kept_task(root, task) for root in roots]
    for root, mine in zip(roots, kept, strict=True):
        if (mine is None) != (kept[0] is None):
            with_files, without = (roots[0], root) if mine is None else (root, roots[0])
            raise DatasetConflict(
                f"'{with_files}' stores the files of its task '{task}', '{without}' stores none: they may be different tasks. "
                "Leave one of them out."
            )
        if kept[0] is not None and mine is not None:
            check_same(kept[0], mine.files, f"those of '{root}'")


def copy_kept(root: Path, task: str, out: Path) -> None:
    """Copy the stored files of a task, if any, to another dataset.

    Raises:
        EpisodeFileError: A file is missing or differs from its SHA-256.
        DatasetConflict: The other dataset stores other files.
        StorageError: The disk cannot be written to.
    """
    kept = kept_task(root, task)
    if kept is not None:
        keep_files(out, task, kept.file, kept.contents())


def kept_faults(root: Path, task: str) -> list[DatasetError]:
    """Return the faults of the stored files of a task; empty if there are no faults or no files."""
    try:
        kept = kept_task(root, task)
        if kept is not None:
            kept.contents()
    except DatasetError as error:
        return [error]
    return []


def _fault(kept: KeptTask, task: str) -> str:
    """Return the fault of a list of files, or an empty text."""
    if kept.task != task:
        return f"it is of the task {kept.task!r}"
    if not all(isinstance(name, str) and isinstance(sha256, str) for name, sha256 in kept.files.items()):
        return "names or checksums are not texts"
    for name in kept.files:
        if not name or PurePosixPath(name).is_absolute() or ".." in PurePosixPath(name).parts or "\0" in name or name == _INDEX:
            return f"{name!r} leads out of its folder"
    if kept.file not in kept.files or not kept.file.endswith(".py") or "/" in kept.file:
        return f"it has no Python file {kept.file!r}"
    return ""


__all__ = ["FOLDER", "KeptTask", "check_alike", "check_same", "copy_kept", "keep_files", "kept_faults", "kept_task"]
