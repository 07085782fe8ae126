"""Files that a command writes in the end: refused at once where they cannot be, and whole or not there."""

from __future__ import annotations

import errno
import json
import os
import tempfile
from pathlib import Path

from rlbench_pin.datasets.storage import storing, write_whole

__all__ = ["check_file", "check_folder", "storing", "write_json", "write_whole"]


def check_folder(folder: Path) -> None:
    """Make a folder and see whether files can be written there, before hours of work.

    Raises:
        StorageError: They cannot.
    """
    with storing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass


def check_file(path: Path) -> None:
    """See whether a file can be written, before the work that it is for; its folder is made.

    Raises:
        StorageError: It cannot.
    """
    with storing(path):
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        check_folder(path.parent)


def write_json(path: Path, content: object) -> None:
    """Write a file for programs.

    Raises:
        StorageError: It cannot be written.
    """
    write_whole(path, (json.dumps(content, indent=1) + "\n").encode())
