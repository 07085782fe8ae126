"""The two files of a task on disk: read together, written together or not at all.

A save first writes a journal next to the files, `.<task>.saving.json`, with both new contents and digests of the old ones. Then
each file is replaced, and the journal is removed. The next opening finishes a save whose journal is left, unless a file has
been changed since.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from rlbench_pin.builder.document.errors import ChangedOnDisk, TaskFilesError
from rlbench_pin.builder.document.texts import Texts
from rlbench_pin.errors import InvalidValue, StorageError, storing
from rlbench_pin.values import as_text

MAX_FILE_SIZE = 4_000_000
"""Largest size of a file of a task [bytes]."""
_JOURNAL_FORMAT = 1
_BASE = re.compile(rb"^base *= *\"([^\"]*)\"", re.MULTILINE)
"""The key of a scene file that names the scene whose tables it takes."""
_PATIENCE = 5.0
"""Time limit for another builder that writes into the same folder [s]."""
Contents = tuple[bytes | None, bytes | None]
"""Of the scene file and the Python file; None for one that does not exist."""


@dataclass(frozen=True)
class Pair:
    """The paths of a task."""

    folder: Path
    name: str

    @property
    def files(self) -> tuple[Path, Path]:
        """The scene file and the Python file."""
        return self.folder / f"{self.name}.toml", self.folder / f"{self.name}.py"

    @property
    def journal(self) -> Path:
        return self.folder / f".{self.name}.saving.json"

    @property
    def draft(self) -> Path:
        return self.folder / f".{self.name}.draft"

    @property
    def parts(self) -> tuple[Path, ...]:
        """The temporary files of a write that was killed."""
        return tuple(_part(path) for path in (*self.files, self.journal, self.draft))


def read_pair(pair: Pair) -> tuple[bytes, bytes]:
    """Return the contents of both files.

    Raises:
        TaskFilesError: A file is missing or too large, or the scene has a base.
        StorageError: A file cannot be read.
    """
    scene = _read(pair.files[0])
    if base := _BASE.search(scene):
        problem = f"it takes its tables from the scene '{base[1].decode(errors='replace')}'."
        raise TaskFilesError(pair.files[0], problem, "Open that task, or edit this file in a text editor.")
    return scene, _read(pair.files[1])


def _on_disk(pair: Pair) -> Contents:
    """Return the contents of both files; None for one that is missing or cannot be read."""
    found: list[bytes | None] = []
    for path in pair.files:
        try:
            found.append(_read(path))
        except (TaskFilesError, StorageError):
            found.append(None)
    return found[0], found[1]


def changed_files(pair: Pair, known: Contents) -> tuple[Path, ...]:
    """Return the files whose content is not the expected one."""
    files = zip(pair.files, _on_disk(pair), known, strict=True)
    return tuple(file for file, content, expected in files if content != expected)


def write_pair(pair: Pair, contents: tuple[bytes, bytes], *, known: Contents | None = None) -> None:
    """Write both files. If the process is killed, either no file has changed, or the next `recover` completes the write.

    Args:
        pair: The paths.
        contents: The new contents.
        known: The contents that the writer has read; None overwrites any.

    Raises:
        ChangedOnDisk: The files have other contents than the known ones.
        StorageError: They cannot be written.
    """
    with storing(pair.folder):
        pair.folder.mkdir(parents=True, exist_ok=True)
        with alone_in(pair.folder):
            if known is not None and (changed := changed_files(pair, known)):
                raise ChangedOnDisk(changed)
            before = [_digest(content) for content in _on_disk(pair)]
            texts = [content.decode() for content in contents]
            journal = json.dumps({"format": _JOURNAL_FORMAT, "before": before, "files": texts}).encode()
            write_whole(pair.journal, journal)
            _finish(pair, contents)


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep other builders from writing into a folder during a block, or until the process ends.

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
    """Lock a folder if its file system supports it; False while another process has locked it."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def write_whole(path: Path, content: bytes) -> None:
    """Replace one file atomically, or raise OSError."""
    _write_temporary(path, content)
    _put_in_place(path)


def recover(pair: Pair) -> tuple[bytes, bytes] | None:
    """Finish a save that was killed.

    Returns:
        The contents of that save if another program has changed a file since; then nothing is written. None otherwise.

    Raises:
        StorageError: The files cannot be written.
    """
    if not any(os.path.lexists(path) for path in (pair.journal, *pair.parts)):
        return None
    with storing(pair.folder), alone_in(pair.folder):
        return _recovered(pair)


def _recovered(pair: Pair) -> tuple[bytes, bytes] | None:
    found = _journal_of(pair)
    for part in pair.parts:
        with suppress(OSError):
            part.unlink(missing_ok=True)
    if found is None:
        return None
    before, contents = found
    now = _on_disk(pair)
    foreign = any(is_now != wanted and _digest(is_now) != was for is_now, wanted, was in zip(now, contents, before, strict=True))
    if foreign:
        pair.journal.unlink(missing_ok=True)
        return contents
    _finish(pair, contents)
    return None


def _finish(pair: Pair, contents: tuple[bytes, bytes]) -> None:
    """Replace both files; a failure before the first is replaced leaves nothing behind."""
    try:
        for path, content in zip(pair.files, contents, strict=True):
            _write_temporary(path, content)
    except BaseException:
        for path in pair.files:
            _part(path).unlink(missing_ok=True)
        pair.journal.unlink(missing_ok=True)
        raise
    for path in pair.files:
        _put_in_place(path)
    pair.journal.unlink(missing_ok=True)
    _sync_folder(pair.folder)


def _write_temporary(path: Path, content: bytes) -> None:
    """Write the new content to a temporary file in the same folder, and flush it to the disk."""
    part = _part(path)
    try:
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def _put_in_place(path: Path) -> None:
    _part(path).replace(path)
    _sync_folder(path.parent)


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _journal_of(pair: Pair) -> tuple[list[str | None], tuple[bytes, bytes]] | None:
    """Return the digests and contents of a journal; None when there is none, or it is invalid."""
    try:
        journal = json.loads(pair.journal.read_bytes())
        if journal["format"] != _JOURNAL_FORMAT:
            return None
        before, (scene, python) = journal["before"], journal["files"]
        return [before[0], before[1]], (scene.encode(), python.encode())
    except (OSError, ValueError, KeyError, TypeError, IndexError, AttributeError):
        return None


def _read(path: Path) -> bytes:
    with storing(path):
        if not path.is_file():
            raise TaskFilesError(path, "it does not exist.", "A task is a pair `<task>.toml` and `<task>.py` in one folder.")
        if (size := path.stat().st_size) > MAX_FILE_SIZE:
            raise TaskFilesError(path, f"it has {size} bytes.", f"Reduce it to at most {MAX_FILE_SIZE}.")
        return path.read_bytes()


def _part(path: Path) -> Path:
    return path.with_name(f".{path.name.removeprefix('.')}.part")


def _digest(content: bytes | None) -> str | None:
    return None if content is None else sha256(content).hexdigest()


# Texts ------------------------------------------------------------------------------------------------------------------------


def decode_pair(pair: Pair, contents: tuple[bytes, bytes]) -> Texts:
    """Return the texts of both files, lines ended by a line feed alone, or raise TaskFilesError."""
    texts = []
    for path, content in zip(pair.files, contents, strict=True):
        try:
            text = content.decode()
        except UnicodeDecodeError as error:
            raise TaskFilesError(path, f"it is not UTF-8: {error.reason} at byte {error.start}.", "Save it as UTF-8.") from error
        texts.append(text.replace("\r\n", "\n") if _ends_lines_with_return(content) else text)
    return texts[0], texts[1]


def encode_pair(texts: Texts, saved: Contents) -> tuple[bytes, bytes]:
    """Return the contents of both files, lines ended as they are on disk."""
    scene, python = (
        (text.replace("\n", "\r\n") if _ends_lines_with_return(content) else text).encode()
        for text, content in zip(texts, saved, strict=True)
    )
    return scene, python


def typed_text(text: str, what: str, saved: bytes | None) -> str:
    """Return a typed text with the line ends of the file in memory, or raise InvalidValue."""
    try:
        as_text(text, what).encode()
    except UnicodeEncodeError as error:
        raise InvalidValue(what, text, f"has to be text that can be written in UTF-8, not {error.reason}") from error
    return text.replace("\r\n", "\n") if saved is None or _ends_lines_with_return(saved) else text


def _ends_lines_with_return(content: bytes | None) -> bool:
    """Whether every line of a file ends with a carriage return and a line feed."""
    return content is not None and 0 < content.count(b"\n") == content.count(b"\r\n") == content.count(b"\r")
