"""Capture of the output of C libraries, without a change of the file descriptors of the process.

PyBullet writes with `printf` to the C library's variables `stdout` and `stderr`. During a capture both refer to a file in memory.
Descriptors 1 and 2, and thus Python's own output, do not change in any thread.
"""

from __future__ import annotations

import ctypes
import os
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass

_APPEND = b"a"


@dataclass
class Captured:
    """Output of the C library."""

    text: str = ""


class OutputSwitch:
    """Redirects the output of C code in this process to a file in memory; for one thread at a time, also nested.

    The file exists as long as the process, because another thread may still print to it when the capture ends. If the C library
    has no such variables, or the system has no files in memory, the output is printed and not captured.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._depth = 0
        self._saved: tuple[int | None, ...] = ()
        self._streams: tuple[ctypes.c_void_p, ...] = ()
        self._c = ctypes.CDLL(None)
        self._descriptor, self._file = -1, None
        try:
            streams = tuple(ctypes.c_void_p.in_dll(self._c, name) for name in ("stdout", "stderr"))
            self._descriptor = os.memfd_create("rlbench_pin_output")
        except (ValueError, AttributeError, OSError):
            return
        self._c.fdopen.restype = ctypes.c_void_p
        self._file = self._c.fdopen(self._descriptor, _APPEND)
        self._streams = streams
        # No child process starts with the lock of another thread.
        os.register_at_fork(before=self._lock.acquire, after_in_parent=self._lock.release, after_in_child=self._lock.release)

    @contextmanager
    def catching(self) -> Iterator[Captured]:
        """Capture the output of a block; the text is available after the block."""
        captured = Captured()
        if not self._streams:
            yield captured
            return
        with self._lock:
            begin = self._begin()
            try:
                yield captured
            finally:
                captured.text = self._end(begin)

    def _begin(self) -> int:
        if self._depth == 0:
            self._saved = tuple(stream.value for stream in self._streams)
            for stream in self._streams:
                stream.value = self._file
        self._depth += 1
        self._flush()
        return os.fstat(self._descriptor).st_size

    def _end(self, begin: int) -> str:
        self._flush()
        self._depth -= 1
        size = os.fstat(self._descriptor).st_size
        text = os.pread(self._descriptor, size - begin, begin).decode(errors="replace")
        if self._depth == 0:
            for stream, before in zip(self._streams, self._saved):
                stream.value = before
            os.ftruncate(self._descriptor, 0)
        return text

    def _flush(self) -> None:
        self._c.fflush(ctypes.c_void_p(self._file))


_SWITCH = OutputSwitch()


def captured_output() -> AbstractContextManager[Captured]:
    """Capture the output of C code, which Python's redirection misses. Output of Python is not captured."""
    return _SWITCH.catching()
