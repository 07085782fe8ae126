"""Atomic writes: a file is complete or absent, also if the disk is full, read-only or removed; and the lock of a folder."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

from rlbench_pin.errors import DatasetConflict, InvalidValue, storing
from rlbench_pin.processes import JournalInUse, exclusive
from rlbench_pin.values import as_path, as_record


@contextmanager
def hold(root: Path) -> Iterator[None]:
    """Lock the folder of a dataset against a second recording or merge; the system unlocks it if the process is killed.

    Raises:
        DatasetConflict: Another process has locked it.
        StorageError: The disk cannot be written to.
    """
    with ExitStack() as held:
        try:
            held.enter_context(exclusive(root / ".recording.lock"))
        except JournalInUse as error:
            raise DatasetConflict(
                f"Another recording or merge into '{root}' is running. Wait for it, or choose another folder."
            ) from error
        yield


def write_whole(path: Path, data: bytes) -> Path:
    """Write a file atomically: it is complete or absent, also if the machine stops.

    The bytes go to a temporary file in the same folder, which is synced to the disk and then renamed.

    Raises:
        StorageError: The disk cannot be written to; the temporary file is removed and an earlier file does not change.
    """
    path, data = as_path(path, "path"), as_record(data, bytes, "data")
    if not path.name:
        raise InvalidValue("path", path, "has to be the name of a file")
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    with storing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with open(temporary, "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
    return path


def remove_leftovers(folder: Path) -> int:
    """Delete the temporary files of killed writers in a folder and its subfolders; return their number."""
    folder = as_path(folder, "folder")
    with storing(folder):
        parts = [part for part in folder.rglob(".*.part") if part.is_symlink() or not part.is_dir()]
        for part in parts:
            part.unlink(missing_ok=True)
    return len(parts)


class DeferredErrorFile(io.FileIO):
    """A file for libraries that crash on a full disk, such as HDF5: it raises an error of the disk only at the end.

    Use it in a `with` block, whose end raises the first error of the disk. `check` raises it earlier.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self.refused: OSError | None = None

    def check(self) -> None:
        """Raise the first error of the disk, if there was one."""
        if self.refused is not None:
            raise self.refused

    def write(self, data: Any) -> int:
        """Write all bytes, or store the error."""
        view = memoryview(data).cast("B")
        done = 0
        try:
            while self.refused is None and done < len(view):
                done += super().write(view[done:])
        except OSError as error:
            self.refused = error
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        """Change the length, or store the error."""
        try:
            return super().truncate(size)
        except OSError as error:
            self.refused = self.refused or error
            return size or 0

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
        if self.refused is not None and error is not self.refused:
            raise self.refused from error
