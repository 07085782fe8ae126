"""The two files of a task on disk: read together, written together or not at all.

A save first leaves a journal beside the files, `.<task>.saving.json`, with what both are to say and what they said. Then
each file is replaced, and the journal goes. Whoever finds a journal finishes the save, unless a file has been changed since.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from rlbench_pin.builder.document.errors import ChangedOnDisk, TaskFilesError
from rlbench_pin.errors import StorageError

LARGEST_FILE = 4_000_000
"""Files of a task have at most so many bytes."""
_LARGEST_JOURNAL = 16 * LARGEST_FILE
_JOURNAL_FORMAT = 1
_PATIENCE = 5.0
"""How long another builder may be writing into the same folder [s]."""
Contents = tuple[bytes | None, bytes | None]
"""Of both files; None for one that is not there."""
Listener = Callable[[str], None]
"""Told each step of a save right after it; what it is called does not matter to the save."""


def _nobody(step: str) -> None:
    """Listen to nothing."""


@dataclass(frozen=True)
class Pair:
    """Where the two files of a task lie."""

    folder: Path
    """Their folder."""
    name: str
    """Name of the task."""

    @property
    def files(self) -> tuple[Path, Path]:
        """The scene file and the Python file."""
        return self.folder / f"{self.name}.toml", self.folder / f"{self.name}.py"

    @property
    def journal(self) -> Path:
        """What a save leaves while it is under way."""
        return self.folder / f".{self.name}.saving.json"

    @property
    def draft(self) -> Path:
        """What is kept of edits that are not saved."""
        return self.folder / f".{self.name}.draft"

    @property
    def parts(self) -> tuple[Path, ...]:
        """What whoever is killed while it writes one of these leaves."""
        return tuple(_part(path) for path in (*self.files, self.journal, self.draft))


def read_pair(pair: Pair) -> tuple[bytes, bytes]:
    """Return what both files say.

    Raises:
        TaskFilesError: One of them is missing, or too large.
        StorageError: One of them cannot be read.
    """
    scene, python = (_read(path) for path in pair.files)
    return scene, python


def on_disk(pair: Pair) -> Contents:
    """Return what both files say; None for one that is missing or cannot be read."""
    found: list[bytes | None] = []
    for path in pair.files:
        try:
            found.append(_read(path))
        except (TaskFilesError, StorageError):
            found.append(None)
    return found[0], found[1]


def changed_files(pair: Pair, known: Contents) -> tuple[Path, ...]:
    """Return the files that say something else than what is known of them; empty when there are none."""
    files = zip(pair.files, on_disk(pair), known, strict=True)
    return tuple(file for file, content, said in files if content != said)


def write_pair(pair: Pair, contents: tuple[bytes, bytes], listen: Listener = _nobody, *, known: Contents | None = None) -> None:
    """Write both files; killed at any instant, either none has changed, or the next `recover` finishes it.

    Args:
        pair: Which files.
        contents: What they are to say.
        listen: Called after each step.
        known: What they say now, as far as the writer knows; None writes over whatever they say.

    Raises:
        ChangedOnDisk: They say something else than what is known.
        StorageError: They cannot be written.
    """
    try:
        pair.folder.mkdir(parents=True, exist_ok=True)
        with alone_in(pair.folder):
            if known is not None and (changed := changed_files(pair, known)):
                raise ChangedOnDisk(changed)
            before = [None if content is None else _digest(content) for content in on_disk(pair)]
            texts = [content.decode() for content in contents]
            journal = json.dumps({"format": _JOURNAL_FORMAT, "before": before, "files": texts}).encode()
            _write_beside(pair.journal, journal, listen)
            _put_in_place(pair.journal, listen)
            _finish(pair, contents, listen)
    except OSError as error:
        raise StorageError(pair.folder, error) from error


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep other builders from writing into a folder during a block; this ends with the process, however that ends.

    Raises:
        OSError: The folder cannot be opened, or another builder is writing into it for longer than a few seconds.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        end = time.monotonic() + _PATIENCE
        while not _locked(descriptor):
            if time.monotonic() > end:
                raise TimeoutError(errno.ETIMEDOUT, "another task builder is writing into it", str(folder))
            time.sleep(0.01)
        yield
    finally:
        os.close(descriptor)


def _locked(descriptor: int) -> bool:
    """Lock a folder, where its file system can; False while somebody else has locked it."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def write_whole(path: Path, content: bytes) -> None:
    """Replace one file, which others see as it was or as it is to be, and in no state between.

    Raises:
        OSError: It cannot be written.
    """
    _write_beside(path, content, _nobody)
    _put_in_place(path, _nobody)


def recover(pair: Pair) -> tuple[bytes, bytes] | None:
    """Finish a save that was killed.

    Returns:
        What was being saved, when a file has been changed since by somebody else; then nothing is written. None otherwise.

    Raises:
        StorageError: The files cannot be written.
    """
    if not any(os.path.lexists(path) for path in (pair.journal, *pair.parts)):
        return None
    try:
        with alone_in(pair.folder):
            return _recovered(pair)
    except OSError as error:
        raise StorageError(pair.folder, error) from error


def _recovered(pair: Pair) -> tuple[bytes, bytes] | None:
    """Finish what a journal says, or return it where a file has been changed since."""
    found = _journal_of(pair)
    for part in pair.parts:
        with suppress(OSError):
            part.unlink(missing_ok=True)
    if found is None:
        return None
    before, contents = found
    now = on_disk(pair)
    foreign = any(
        is_now != wanted and (None if is_now is None else _digest(is_now)) != was
        for is_now, wanted, was in zip(now, contents, before, strict=True)
    )
    if foreign:
        pair.journal.unlink(missing_ok=True)
        return contents
    _finish(pair, contents, _nobody)
    return None


def _finish(pair: Pair, contents: tuple[bytes, bytes], listen: Listener) -> None:
    """Replace both files; what fails before the first is replaced leaves nothing behind."""
    try:
        for path, content in zip(pair.files, contents, strict=True):
            _write_beside(path, content, listen)
    except BaseException:
        for path in pair.files:
            _part(path).unlink(missing_ok=True)
        pair.journal.unlink(missing_ok=True)
        raise
    for path in pair.files:
        _put_in_place(path, listen)
    pair.journal.unlink(missing_ok=True)
    _sync_folder(pair.folder)
    listen("the journal is gone")


def _write_beside(path: Path, content: bytes, listen: Listener) -> None:
    """Write what a file is to say to a temporary file beside it, down to the disk."""
    part = _part(path)
    try:
        with part.open("wb") as file:
            listen(f"{part.name} is empty")
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise
    listen(f"{part.name} is written")


def _put_in_place(path: Path, listen: Listener) -> None:
    _part(path).replace(path)
    _sync_folder(path.parent)
    listen(f"{path.name} is replaced")


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _journal_of(pair: Pair) -> tuple[list[str | None], tuple[bytes, bytes]] | None:
    """Return what a journal says; None when there is none, or it is not one of ours."""
    try:
        if pair.journal.stat().st_size > _LARGEST_JOURNAL:
            return None
        journal = json.loads(pair.journal.read_bytes())
        if journal["format"] != _JOURNAL_FORMAT:
            return None
        before, (scene, python) = journal["before"], journal["files"]
        return [before[0], before[1]], (scene.encode(), python.encode())
    except (OSError, ValueError, KeyError, TypeError, IndexError, AttributeError):
        return None


def _read(path: Path) -> bytes:
    try:
        if not path.is_file():
            raise TaskFilesError(path, "it does not exist.", "A task is a pair `<task>.toml` and `<task>.py` in one folder.")
        if (size := path.stat().st_size) > LARGEST_FILE:
            raise TaskFilesError(path, f"it has {size} bytes.", f"A file of a task has at most {LARGEST_FILE}.")
        return path.read_bytes()
    except OSError as error:
        raise StorageError(path, error) from error


def _part(path: Path) -> Path:
    return path.with_name(f".{path.name.removeprefix('.')}.part")


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()
