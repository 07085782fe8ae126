"""The manifest of a task: what every episode is, and the SHA-256 that says it is still the same."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path

from rlbench_pin.datasets.layout import episode_files, manifest_path
from rlbench_pin.errors import DatasetError

VERSION = 1
_BLOCK = 1 << 20

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


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file, in hexadecimal."""
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()


def read_manifest(root: Path, task: str) -> tuple[EpisodeEntry, ...]:
    """Return what the manifest of a task lists, by variation and episode; nothing when there is none."""
    entries = _read(manifest_path(root, task))
    return tuple(entries[key] for key in sorted(entries))


def verify_task(root: Path, task: str) -> None:
    """Check every stored episode of a task against its manifest.

    Raises:
        DatasetError: Naming the first file that is missing, altered or not listed.
    """
    folder = manifest_path(root, task).parent
    entries = read_manifest(root, task)
    for entry in entries:
        path = folder / entry.file
        if not path.is_file():
            raise DatasetError(f"'{path}' is listed in {manifest_path(root, task)} but does not exist. Record it again.")
        if file_digest(path) != entry.sha256:
            raise DatasetError(f"'{path}' is not the file its manifest describes: the SHA-256 differs. Record it again.")
    listed = {folder / entry.file for entry in entries}
    unlisted = [path for path in episode_files(root, task) if path not in listed]
    if unlisted:
        raise DatasetError(f"'{unlisted[0]}' is not listed in {manifest_path(root, task)}. Add it with `DatasetWriter.add`.")


@contextmanager
def locked_manifest(root: Path, task: str) -> Iterator[Entries]:
    """Yield the entries of a manifest, to be changed; they are written when the block ends. One process at a time."""
    path = manifest_path(root, task)
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path.with_name(f".{path.name}.lock"), "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        entries = _read(path)
        yield entries
        _write(path, task, entries)


def _read(path: Path) -> Entries:
    if not path.exists():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        version = content["version"]
        entries = [EpisodeEntry(**entry) for entry in content["episodes"]] if version == VERSION else []
    except (ValueError, KeyError, TypeError) as error:
        raise DatasetError(
            f"The manifest '{path}' cannot be read: {error}. Restore it, or delete it and record again."
        ) from error
    if version != VERSION:
        raise DatasetError(f"The manifest '{path}' has version {version}; this package reads version {VERSION}.")
    return {(entry.variation, entry.episode): entry for entry in entries}


def _write(path: Path, task: str, entries: Entries) -> None:
    content = {"version": VERSION, "task": task, "episodes": [asdict(entries[key]) for key in sorted(entries)]}
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    temporary.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    os.replace(temporary, path)
