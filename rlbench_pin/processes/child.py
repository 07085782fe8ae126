"""Child processes that run a module of this package and end with their owner: policies, learners, the builder's worlds.

The owner starts a child with `ChildProcess` and communicates over a socket, usually with messages (`policy_server.Channel`) whose
`receive(timeout)` sets the time limit. The module calls `connect_to_owner` first, then `limit_memory` where memory is limited.

A supervisor process runs between owner and module: this file, run as a program. It is the subreaper of all descendants: a process
that loses its parent becomes a child of the supervisor, even in another session or with another environment. The supervisor
therefore finds all descendants. It ends them when the module ends, when the owner requests it, and when the owner has ended.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import re
import resource
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

KEPT = 16_384
"""Number of bytes of a child's output that are kept."""
LAST_LINES = 12
"""Maximum number of lines that `printed` returns."""
PATIENCE = 10.0
"""Time limit for the supervisor to end all descendants [s]; then the supervisor is killed."""
_SET_PDEATHSIG, _SET_CHILD_SUBREAPER = 1, 36
"""Options of prctl(2)."""


class ChildProcess:
    """A process in its own session, so that Ctrl-C in the terminal does not interrupt it. It ends with this process.

    It runs `python -m MODULE SOCKET PIPE ARGUMENTS...` with the import path and the environment of this process. Its standard
    input is empty; the end of its standard output and error is kept for `printed`.

    Args:
        module: Module to run.
        arguments: Arguments of the module.
        variables: Further environment variables, which its descendants inherit.

    Attributes:
        connection: This side of the socket. The caller closes it.
        pid: Process id.

    Raises:
        OSError: The process cannot be started.
    """

    def __init__(self, module: str, arguments: Sequence[str] = (), variables: Mapping[str, str] | None = None) -> None:
        self._lock = threading.Lock()
        self._ending: str | None = None
        self.connection, theirs = socket.socketpair()
        watched, held = os.pipe()
        paths = os.pathsep.join(path for path in sys.path if path)
        environment = {**os.environ, **(variables or {}), "PYTHONPATH": paths, "PYTHONUNBUFFERED": "1"}
        command = [sys.executable, "-I", "-S", __file__, str(watched), str(theirs.fileno()), module, *arguments]
        try:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
                pass_fds=(theirs.fileno(), watched), env=environment,
            )  # fmt: skip
        except BaseException:
            self.connection.close()
            os.close(held)
            raise
        finally:
            theirs.close()
            os.close(watched)
        self.pid = self._process.pid
        self._alive = os.fdopen(held, "wb")
        assert self._process.stdout is not None
        self._output = _Output(self._process.stdout)

    def end(self, patience: float = 0.0) -> str:
        """End the process and its descendants. Several calls, also from other threads, are allowed.

        Args:
            patience: Time to wait first for the process to end by itself [s].

        Returns:
            A sentence with the exit code or signal if the process ended by itself, else "".
        """
        with self._lock:
            if self._ending is None:
                ended_itself = self._ends_within(patience)
                self._alive.close()  # the supervisor ends all descendants
                if not self._ends_within(PATIENCE):
                    self._process.kill()
                code = self._process.wait()
                self._output.finish()
                self._ending = _describe(code) if ended_itself else ""
            return self._ending

    def printed(self) -> str:
        """Return the last lines that the process printed."""
        return self._output.last_lines()

    def _ends_within(self, seconds: float) -> bool:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)
        return self._process.returncode is not None


class _Output:
    """The last output of a process, read by a thread, so that the process never waits for a reader."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._kept: deque[bytes] = deque()
        self._stream = stream
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        size = 0
        with contextlib.suppress(OSError, ValueError):
            while part := os.read(self._stream.fileno(), 4096):
                self._kept.append(part)
                size += len(part)
                while size - len(self._kept[0]) > KEPT:
                    size -= len(self._kept.popleft())

    def finish(self) -> None:
        """Wait for the end of the output, at most 1 s, because another process can keep the stream open."""
        self._thread.join(1.0)
        if not self._thread.is_alive():
            self._stream.close()

    def last_lines(self) -> str:
        text = b"".join(self._kept)[-KEPT:].decode(errors="replace")
        return "\n".join(line[:500] for line in text.strip().splitlines()[-LAST_LINES:])


def _describe(code: int) -> str:
    """Return an exit code or signal as a sentence."""
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"Its process was ended by {signal.Signals(-code).name}."
    return f"Its process ended with exit code {code}."


# In the child -----------------------------------------------------------------------------------------------------------------


def connect_to_owner() -> tuple[socket.socket, list[str]]:
    """Return the socket to the owner and the arguments of the module. From now on this process ends with its supervisor."""
    supervisor, connection = int(sys.argv[1]), int(sys.argv[2])
    os.set_inheritable(connection, False)
    _prctl(_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != supervisor:  # it has ended already
        os._exit(1)
    return socket.socket(fileno=connection), sys.argv[3:]


def limit_memory(more: int) -> None:
    """Limit the address space of this process and its descendants to the current size plus `more` bytes; disable core dumps."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    found = re.search(r"VmSize:\s+(\d+) kB", status)
    used = 0 if found is None else 1024 * int(found[1])
    resource.setrlimit(resource.RLIMIT_AS, (used + more, used + more))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _prctl(option: int, value: int) -> None:
    if ctypes.CDLL(None, use_errno=True).prctl(option, value, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), f"prctl({option}, {value}) failed")


# In the supervisor ------------------------------------------------------------------------------------------------------------


def _supervise(pipe: int, connection: int, module: str, arguments: Sequence[str]) -> int:
    """Run the module until it ends or the owner closes the pipe; end all descendants.

    Returns:
        The exit code of the module; the number of a signal is negative.
    """
    _prctl(_SET_CHILD_SUBREAPER, 1)
    os.set_inheritable(pipe, False)
    woken, wake = os.pipe()
    for end in (woken, wake):
        os.set_blocking(end, False)
    signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda number, frame: None)
    command = [sys.executable, "-m", module, str(os.getpid()), str(connection), *arguments]
    main = os.posix_spawn(sys.executable, command, os.environ, setsid=True)
    os.close(connection)
    ended: dict[int, int] = {}
    while main not in ended and pipe not in select.select([pipe, woken], [], [])[0]:
        os.read(woken, 4096)
        ended = _reap()
    limit = time.monotonic() + PATIENCE
    while _has_children() and time.monotonic() < limit:
        for pid in _descendants(os.getpid()):
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
        time.sleep(0.002)
        ended |= _reap()
    return ended.get(main, 1)


def _reap() -> dict[int, int]:
    """Wait for all children that have ended; return process id -> exit code."""
    ended: dict[int, int] = {}
    with contextlib.suppress(ChildProcessError):
        while (found := os.waitpid(-1, os.WNOHANG))[0]:
            ended[found[0]] = os.waitstatus_to_exitcode(found[1])
    return ended


def _has_children() -> bool:
    """Return whether this process has children."""
    with contextlib.suppress(ChildProcessError):
        os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOHANG | os.WNOWAIT)
        return True
    return False


def _descendants(ancestor: int) -> list[int]:
    """Return the ids of all processes below a process."""
    children: dict[int, list[int]] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended
            parent = int((entry / "stat").read_bytes().rpartition(b")")[2].split()[1])
            children.setdefault(parent, []).append(int(entry.name))
    found = list(children.get(ancestor, ()))
    for pid in found:
        found += children.get(pid, ())
    return found


def _end_like(code: int) -> None:
    """End this process with an exit code; for a negative code by the signal with this number."""
    if code < 0:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with contextlib.suppress(OSError):  # SIGKILL cannot have a handler
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(code)


if __name__ == "__main__":
    _end_like(_supervise(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4:]))
