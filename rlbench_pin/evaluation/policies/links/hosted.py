"""A process of a policy's own: started, listened to, ended."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Mapping, Sequence
from typing import IO

from rlbench_pin.evaluation.policies.faults import FaultKind, PolicyFault
from rlbench_pin.evaluation.policies.policy_server import Channel

HOST = "rlbench_pin.evaluation.policies.links.host"
"""The module that runs in it."""
KEPT = 16_384
"""Bytes of what it prints that are kept."""
LAST_LINES = 12
"""So many lines of that are shown."""


class HostedPolicy:
    """A link to a policy in a process of its own, which no Ctrl-C of the terminal reaches and which ends with this one.

    Args:
        reference: What the policy is called.
        target: `module:factory` or `file.py:factory`, with its arguments.
        host: The module that runs in the process.
        more: Further arguments of that.
        variables: Further variables of its environment, which what it starts inherits.
    """

    lost: FaultKind = "crashed"

    def __init__(
        self, reference: str, target: str, host: str = HOST, more: Sequence[str] = (), variables: Mapping[str, str] | None = None
    ) -> None:
        self.reference, self._target, self._host, self._more = reference, target, host, tuple(more)
        self._variables = {} if variables is None else dict(variables)
        self._process: subprocess.Popen[bytes] | None = None
        self._alive: IO[bytes] | None = None
        self._output = Output()

    def open(self, timeout: float) -> Channel:
        """Start the process and return the channel to it; the policy in it is made at the first question."""
        self.close()
        ours, theirs = socket.socketpair()
        watched, held = os.pipe()
        command = [sys.executable, "-m", self._host, str(theirs.fileno()), str(watched), self._target, *self._more]
        paths = os.pathsep.join(path for path in sys.path if path)
        variables = {**os.environ, **self._variables, "PYTHONPATH": paths, "PYTHONUNBUFFERED": "1"}
        try:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
                pass_fds=(theirs.fileno(), watched), env=variables,
            )  # fmt: skip
        except OSError as error:
            ours.close()
            os.close(held)
            raise PolicyFault("crashed", f"Its process could not be started: {error}.", "Free memory or processes.") from error
        finally:
            theirs.close()
            os.close(watched)
        self._alive = os.fdopen(held, "wb")
        assert self._process.stdout is not None
        self._output = Output(self._process.stdout)
        return Channel(ours)

    def close(self, patience: float = 0.0) -> str:
        """End the process and what it started, and say how it ended."""
        process, self._process = self._process, None
        if process is None:
            return ""
        ended = _ends_within(process.pid, patience)
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)  # not yet waited for, so the number is still its own
        code = process.wait()
        self._output.finish()
        if self._alive is not None:
            self._alive.close()
        return _ending(code) if ended else ""

    def printed(self) -> str:
        """Return the last lines that the policy printed."""
        return self._output.last_lines()


class Output:
    """The end of what a process prints, read by a thread so that the process never waits.

    Args:
        stream: What it prints to; None is nothing.
    """

    def __init__(self, stream: IO[bytes] | None = None) -> None:
        self._kept: deque[bytes] = deque()
        self._stream, self._thread = stream, None
        if stream is not None:
            self._thread = threading.Thread(target=self._read, daemon=True)
            self._thread.start()

    def _read(self) -> None:
        assert self._stream is not None
        size = 0
        with contextlib.suppress(OSError, ValueError):
            while part := os.read(self._stream.fileno(), 4096):
                self._kept.append(part)
                size += len(part)
                while size - len(self._kept[0]) > KEPT:
                    size -= len(self._kept.popleft())

    def finish(self) -> None:
        """Wait until everything is read; not for long, should something else hold the stream."""
        if self._thread is not None:
            self._thread.join(1.0)
        if self._stream is not None and self._thread is not None and not self._thread.is_alive():
            self._stream.close()

    def last_lines(self) -> str:
        """Return the last lines."""
        text = b"".join(self._kept)[-KEPT:].decode(errors="replace")
        return "\n".join(line[:500] for line in text.strip().splitlines()[-LAST_LINES:])


def _has_ended(pid: int) -> bool:
    """Whether a child has ended; it stays to be waited for."""
    try:
        return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return True


def _ends_within(pid: int, seconds: float) -> bool:
    end = time.monotonic() + seconds
    while not (ended := _has_ended(pid)) and time.monotonic() < end:
        time.sleep(0.005)
    return ended


def _ending(code: int) -> str:
    if code < 0:
        with contextlib.suppress(ValueError):
            return f"Its process was ended by {signal.Signals(-code).name}."
    return f"Its process ended with exit code {code}."
