"""Writing to a disk that may be full, read-only or pulled out: whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rlbench_pin.errors import StorageError


@contextmanager
def storing(path: Path) -> Iterator[None]:
    """Turn what the disk says about `path` into a StorageError."""
    try:
        yield
    except OSError as error:
        raise StorageError(path, error) from error


def write_whole(path: Path, data: bytes) -> Path:
    """Write a file that appears whole or not at all, also when the machine stops: aside, to the disk, renamed.

    Raises:
        StorageError: The disk refused; nothing is left behind and an earlier file of that name is as it was.
    """
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
    """Delete the parts that killed writers left below a folder; return how many there were."""
    parts = list(folder.rglob(".*.part"))
    for part in parts:
        part.unlink(missing_ok=True)
    return len(parts)
