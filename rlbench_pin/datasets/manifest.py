"""The manifest of a task: seed, variation, versions and SHA-256 of every episode.

`manifest.json` lists the episodes. During a recording each new entry is appended as one line to `.manifest.journal` next to it.
So the cost of an entry does not grow with the number of episodes. Readers of the manifest read the journal as well.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from rlbench_pin.datasets.layout import check_inside, episode_file, manifest_path, stored_variations
from rlbench_pin.datasets.storage import write_whole
from rlbench_pin.errors import EpisodeFileError, storing

LARGEST = 2**64 - 1
"""The largest number that a dataset stores."""
MAX_FRAMES = 10_000_000
"""More frames than any episode has."""
ONLY_ARM = "panda"
"""The arm of episodes that do not name theirs: they are older than the other arms."""
_SHOWN = 60


def parse_json(text: str | bytes) -> Any:
    """Return the value of a JSON text.

    Raises:
        ValueError: It is not JSON, is nested too deeply, or contains NaN or infinity.
    """
    try:
        return json.loads(text, parse_constant=_refuse)
    except RecursionError as error:
        raise ValueError("it is nested too deeply") from error


def is_whole(value: object, low: int = 0, high: int = LARGEST) -> bool:
    """Whether a value is a whole number in a range that includes both ends; booleans are not numbers."""
    return type(value) is int and low <= value <= high


def is_texts(value: object) -> bool:
    """Whether a value is a list of texts."""
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def is_text_map(value: object) -> bool:
    """Whether a value is a dict of texts."""
    return isinstance(value, dict) and all(isinstance(item, str) for pair in value.items() for item in pair)


def short(value: object) -> str:
    """Return a value as text, short enough for a message."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # a number with thousands of digits; a list that is too deep
        text = f"a {type(value).__name__}"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"it contains {constant}, which is not a finite number")


VERSION = 1
_BLOCK = 1 << 20
_JOURNAL = ".manifest.journal"
_SHA256 = re.compile("[0-9a-f]{64}")
_MAX_EPISODES = 2**31 - 1

Entries = dict[tuple[int, int], "EpisodeEntry"]


@dataclass(frozen=True)
class EpisodeEntry:
    """One line of the manifest."""

    file: str
    """Path below the folder of the task."""
    variation: int
    episode: int
    frames: int
    random_seed: int | None
    attempt: int
    num_bytes: int
    sha256: str
    instructions: list[str] = field(default_factory=list)
    versions: dict[str, str] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    """Why each earlier attempt of the seed failed."""
    robot: str = ONLY_ARM
    """Name of the arm."""
    task_version: int = 1
    """Version of the task; 1 in manifests that do not record it."""

    def check(self, manifest: Path) -> None:
        """Raise EpisodeFileError if the entry names another file than that of its episode."""
        for name, is_right in _FIELDS.items():
            if not is_right(value := getattr(self, name)):
                raise EpisodeFileError(
                    manifest,
                    f"The manifest '{manifest}' has a damaged entry for {short(self.file)}: {name} = {short(value)}. Restore it.",
                )
        expected = episode_file(self.variation, self.episode)
        if self.file != expected:
            raise EpisodeFileError(
                manifest,
                f"The manifest '{manifest}' lists {short(self.file)} where '{expected}' belongs. Do not trust this dataset.",
            )


_FIELDS: dict[str, Callable[[object], bool]] = {
    "file": lambda value: isinstance(value, str),
    "variation": lambda value: is_whole(value, 0, _MAX_EPISODES),
    "episode": lambda value: is_whole(value, 0, _MAX_EPISODES),
    "frames": lambda value: is_whole(value, 1, MAX_FRAMES),
    "random_seed": lambda value: value is None or is_whole(value),
    "attempt": is_whole,
    "num_bytes": is_whole,
    "sha256": lambda value: isinstance(value, str) and _SHA256.fullmatch(value) is not None,
    "instructions": is_texts,
    "versions": is_text_map,
    "failures": is_texts,
    "robot": lambda value: isinstance(value, str),
    "task_version": lambda value: is_whole(value, 1),
}
"""Check of each field of an entry."""


def digest(data: bytes) -> str:
    """Return the SHA-256 of some bytes, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file, in hexadecimal."""
    running = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(_BLOCK):
            running.update(block)
    return running.hexdigest()


def read_manifest(root: Path, task: str) -> tuple[EpisodeEntry, ...]:
    """Return the entries in the manifest of a task, by variation and episode; empty if there is no manifest.

    Raises:
        DatasetError: The folder is not a dataset, has no episodes of the task, or the manifest is damaged, of another version
            or task, or names files outside of its folder.
    """
    if not has_manifest(root, task) and not stored_variations(root, task):
        raise EpisodeFileError(
            manifest_path(root, task),
            f"'{root}' is not a dataset with episodes of '{task}': it has neither a manifest nor variations of it. "
            f"Record some with `rlbench-pin record {task} --out {root}`.",
        )
    entries = _read(manifest_path(root, task), task)
    return tuple(entries[key] for key in sorted(entries))


def has_manifest(root: Path, task: str) -> bool:
    """Whether a task has a manifest or a journal."""
    path = manifest_path(root, task)
    return path.exists() or journal_path(path).exists()


@contextmanager
def locked_manifest(root: Path, task: str) -> Iterator[Entries]:
    """Yield the entries of a manifest for changes; they are written at the end of the block. Locks out other processes."""
    path = manifest_path(root, task)
    with _lock(path):
        entries = _read(path, task)
        yield entries
        _write(path, task, entries)
        journal_path(path).unlink(missing_ok=True)


def append_entry(root: Path, task: str, entry: EpisodeEntry) -> None:
    """Append one episode to the journal; `fold_journal` moves it to the manifest.

    Raises:
        StorageError: The disk cannot be written to; the episode does not count.
    """
    path = manifest_path(root, task)
    line = json.dumps(asdict(entry)).encode() + b"\n"
    with _lock(path), storing(journal_path(path)), open(journal_path(path), "ab") as file:
        whole = _length_of_whole_lines(journal_path(path))
        file.truncate(whole)
        try:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        except OSError:
            os.truncate(journal_path(path), whole)
            raise


def fold_journal(root: Path, task: str) -> None:
    """Move the entries of the journal to the manifest."""
    if journal_path(manifest_path(root, task)).exists():
        with locked_manifest(root, task):
            pass


def journal_path(manifest: Path) -> Path:
    """Return the path of the journal of a manifest."""
    return manifest.with_name(_JOURNAL)


@contextmanager
def _lock(path: Path) -> Iterator[None]:
    _check_place(path)
    with storing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = open(path.with_name(f".{path.name}.lock"), "w", encoding="utf-8")  # noqa: SIM115
    with lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _check_place(manifest: Path) -> None:
    """Refuse links out of the dataset before the first access to a file."""
    for path in (manifest, journal_path(manifest)):
        check_inside(manifest.parents[1], path)


def _read(path: Path, task: str) -> Entries:
    _check_place(path)
    stored = [*_read_file(path, task), *_read_journal(path)]
    for entry in stored:
        entry.check(path)
    return {(entry.variation, entry.episode): entry for entry in stored}


def _read_file(path: Path, task: str) -> list[EpisodeEntry]:
    if not path.exists():
        return []
    try:
        content = parse_json(path.read_text(encoding="utf-8"))
        version = content["version"]
        entries = [EpisodeEntry(**entry) for entry in content["episodes"]] if version == VERSION else []
        named = content.get("task", task)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise EpisodeFileError(
            path, f"The manifest '{path}' cannot be read: {error}. Restore it, or delete it and record again."
        ) from error
    if version != VERSION:
        raise EpisodeFileError(
            path,
            f"The manifest '{path}' has version {short(version)}; this package reads version {VERSION}. "
            "Read it with the release of rlbench_pin that wrote it, or record again.",
        )
    if named != task:
        raise EpisodeFileError(path, f"The manifest '{path}' is of the task {short(named)}. Name the folder like its task.")
    return entries


def _read_journal(manifest: Path) -> list[EpisodeEntry]:
    """Read the complete lines of the journal; an incomplete last line is ignored."""
    path = journal_path(manifest)
    if not path.exists():
        return []
    try:
        text = path.read_bytes()
        lines: list[dict[str, Any]] = [parse_json(line) for line in text[: text.rfind(b"\n") + 1].splitlines()]
        return [EpisodeEntry(**line) for line in lines]
    except (OSError, ValueError, TypeError) as error:
        raise EpisodeFileError(
            path, f"The journal '{path}' cannot be read: {error}. Delete it and continue with `--resume`."
        ) from error


def _length_of_whole_lines(path: Path) -> int:
    """Return the end of the last complete line; the rest was cut off by a crash."""
    with open(path, "rb") as file:
        end = file.seek(0, os.SEEK_END)
        while end > 0:
            start = max(0, end - _BLOCK)
            file.seek(start)
            found = file.read(end - start).rfind(b"\n")
            if found >= 0:
                return start + found + 1
            end = start
    return 0


def _write(path: Path, task: str, entries: Entries) -> None:
    content = {"version": VERSION, "task": task, "episodes": [asdict(entries[key]) for key in sorted(entries)]}
    write_whole(path, (json.dumps(content, indent=1) + "\n").encode())
