"""Keeps the process of a learner out of a folder and of other processes: by Landlock, where the system is a Linux that has it.

Landlock allows what is named, so that everything beside the folder and beside the folders above it is named, as it is at that
moment. What is made later directly in one of the folders above cannot be opened; a temporary folder is made beforehand.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import shutil
import struct
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_CREATE, _ADD, _RESTRICT, _VERSION, _NO_NEW_PRIVILEGES = 444, 445, 446, 1, 38
"""Numbers of system calls, the same on all processors, of a flag, and of an option of `prctl`."""
_WRITE, _READ, _REFER, _TRUNCATE = 1 << 1, 1 << 2, 1 << 13, 1 << 14
"""Rights: to open files for writing and reading, to link and move between folders, to cut files."""


def can_confine() -> bool:
    """Return whether the system can keep a process out of folders."""
    return _version() >= 2


def confine(withheld: Path) -> bool:
    """Keep this process, and those that it starts, from opening files below a folder and from looking into other processes.

    Args:
        withheld: The folder; it exists.

    Returns:
        Whether the system can.
    """
    version = _version()
    if version < 2:
        return False
    _own_temporary_folder()
    rights = _WRITE | _READ | _REFER | (_TRUNCATE if version >= 3 else 0)
    ruleset = _call(_CREATE, struct.pack("=Q", rights), 8, 0)
    for path in beside(withheld.resolve()):
        with suppress(OSError):  # it has gone, or may not be looked at in any case
            opened = os.open(path, os.O_PATH | os.O_CLOEXEC)
            try:
                allowed = rights if path.is_dir() else rights & ~_REFER
                _call(_ADD, ruleset, 1, struct.pack("=Qi", allowed, opened), 0)
            finally:
                os.close(opened)
    ctypes.CDLL(None).prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    _call(_RESTRICT, ruleset, 0)
    os.close(ruleset)
    return True


def beside(folder: Path) -> Iterator[Path]:
    """Yield what lies beside a folder and beside those above it, without links, whose targets lie somewhere themselves."""
    for inner in (folder, *folder.parents[:-1]):
        with suppress(PermissionError):
            yield from (path for path in inner.parent.iterdir() if path != inner and not path.is_symlink())


def _own_temporary_folder() -> None:
    folder = tempfile.mkdtemp(prefix="rlbench_pin_learner_")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ["TMPDIR"] = tempfile.tempdir = folder


def _version() -> int:
    """Return the version of Landlock; 0 where there is none."""
    if sys.platform != "linux":
        return 0
    with suppress(OSError):
        return _call(_CREATE, None, 0, _VERSION)
    return 0


def _call(number: int, *arguments: bytes | int | None) -> int:
    library = ctypes.CDLL(None, use_errno=True)
    made = [ctypes.c_long(a) if isinstance(a, int) else a for a in arguments]
    answer = int(library.syscall(ctypes.c_long(number), *made))
    if answer < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return answer
