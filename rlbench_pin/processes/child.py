"""Child processes that run a module of this package and end with their owner: policies, learners, the builder's worlds.

The owner starts one with `ChildProcess` and talks to it over a socket, usually in messages (`policy_server.Channel`) whose
`receive(timeout)` sets the time limit. The module calls `connect_to_owner` first, then `limit_memory` where memory is limited.
"""

from __future__ import annotations

import contextlib
import fcntl
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
import uuid
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

KEPT = 16_384
"""Bytes of the output of a child that are kept."""
LAST_LINES = 12
"""Lines of them that `printed` returns."""
MARK = "RLBENCH_PIN_CHILD"
"""Environment variable that a child and its descendants share; its value is unique to the child."""


class ChildProcess:
    """A process in a session of its own, so that Ctrl-C in the terminal does not reach it. It ends with this process.

    It runs `python -m MODULE SOCKET PIPE ARGUMENTS...` with the import path and the environment of this process. It reads
    nothing from standard input; standard output and error are kept for `printed`.

    Args:
        module: The module that runs in it.
        arguments: Its arguments.
        variables: Further environment variables, which its descendants inherit.

    Attributes:
        connection: This side of the socket. Closing it is left to the user.
        pid: Process id.

    Raises:
        OSError: The process cannot be started.
    """

    def __init__(self, module: str, arguments: Sequence[str] = (), variables: Mapping[str, str] | None = None) -> None:
        self._mark, self._lock = uuid.uuid4().hex, threading.Lock()
        self._ending: str | None = None
        self.connection, theirs = socket.socketpair()
        watched, held = os.pipe()
        command = [sys.executable, "-m", module, str(theirs.fileno()), str(watched), *arguments]
        paths = os.pathsep.join(path for path in sys.path if path)
        environment = {**os.environ, **(variables or {}), MARK: self._mark, "PYTHONPATH": paths, "PYTHONUNBUFFERED": "1"}
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
        """End the process and its descendants. May be called again, and from other threads.

        Args:
            patience: How long it may take to end by itself first [s].

        Returns:
            A sentence with the exit code or signal if it ended by itself, else "".
        """
        with self._lock:
            if self._ending is None:
                ended_itself = self._ends_within(patience)
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(self.pid, signal.SIGKILL)  # not yet waited for, so the number is still its own
                code = self._process.wait()
                self._kill_marked()
                self._output.finish()
                self._alive.close()
                self._ending = _describe(code) if ended_itself else ""
            return self._ending

    def printed(self) -> str:
        """Return the last lines that the process printed."""
        return self._output.last_lines()

    def _ends_within(self, seconds: float) -> bool:
        end = time.monotonic() + seconds
        while not (ended := _has_ended(self.pid)) and time.monotonic() < end:
            time.sleep(0.005)
        return ended

    def _kill_marked(self) -> None:
        """Kill descendants that left the process group; where there is no `/proc`, they stay."""
        mark = f"{MARK}={self._mark}".encode()
        for _ in range(3):  # one of them may start another meanwhile
            found = [int(entry.name) for entry in Path("/proc").glob("[0-9]*") if _has_variable(entry, mark)]
            if not found:
                return
            for number in found:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.kill(number, signal.SIGKILL)


class _Output:
    """The end of what a process prints, read by a thread so that the process never waits."""

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
        """Wait until everything is read; not for long, should something else hold the stream."""
        self._thread.join(1.0)
        if not self._thread.is_alive():
            self._stream.close()

    def last_lines(self) -> str:
        text = b"".join(self._kept)[-KEPT:].decode(errors="replace")
        return "\n".join(line[:500] for line in text.strip().splitlines()[-LAST_LINES:])


def _has_ended(pid: int) -> bool:
    """Whether a child has ended; it stays to be waited for."""
    try:
        return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return True


def _has_variable(entry: Path, variable: bytes) -> bool:
    try:
        return variable in (entry / "environ").read_bytes().split(b"\0")
    except OSError:  # it has ended, or belongs to another user
        return False


def _describe(code: int) -> str:
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"Its process was ended by {signal.Signals(-code).name}."
    return f"Its process ended with exit code {code}."


# In the child -----------------------------------------------------------------------------------------------------------------


def connect_to_owner() -> tuple[socket.socket, list[str]]:
    """Return the socket to the owner and the arguments of the module, and let this process end with the owner.

    The owner holds the other end of a pipe. When that is closed, by the system if need be, the system sends SIGIO to the group
    of this process, which ends all in it.
    """
    connection, pipe = int(sys.argv[1]), int(sys.argv[2])
    os.set_inheritable(connection, False)
    os.set_inheritable(pipe, False)
    fcntl.fcntl(pipe, fcntl.F_SETOWN, -os.getpgrp())
    fcntl.fcntl(pipe, fcntl.F_SETFL, fcntl.fcntl(pipe, fcntl.F_GETFL) | os.O_ASYNC)
    if select.select([pipe], [], [], 0.0)[0]:  # the owner has ended already
        os._exit(1)
    return socket.socket(fileno=connection), sys.argv[3:]


def limit_memory(more: int) -> None:
    """Allow this process and its descendants so many bytes of address space beyond what it has now; no core dumps."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    found = re.search(r"VmSize:\s+(\d+) kB", status)
    used = 0 if found is None else 1024 * int(found[1])
    resource.setrlimit(resource.RLIMIT_AS, (used + more, used + more))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
