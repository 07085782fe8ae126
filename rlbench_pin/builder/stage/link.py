"""The server's side of one process of the stage: started, asked, ended, started again."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rlbench_pin.builder.contracts import Problem
from rlbench_pin.builder.stage.faults import FaultKind, NothingOpen, StageFault, StageStopped
from rlbench_pin.builder.stage.folder import OWNER
from rlbench_pin.builder.stage.limits import StageLimits
from rlbench_pin.builder.stage.problems import dumped_line
from rlbench_pin.evaluation.policies.policy_server import Channel, WireError
from rlbench_pin.processes.child import ChildProcess

HOST = "rlbench_pin.builder.stage.inside.host"
"""The module that runs in the process."""
_DUMP_WAIT = 0.5
"""How long a process that hangs is given to say where it is [s]."""

_STOP_WAIT = 1.0
"""How long what is to stop is given to do so by itself [s]."""

OnNote = Callable[[str, Any], None]
"""Called with the name and the content of what arrives before the answer."""


class Link:
    """A process that answers one question at a time, started when it is needed and again when it is gone.

    Args:
        name: What its files are called by.
        folder: The private folder.
        limits: Times and memory.

    Attributes:
        generation: How many processes there were; what was opened in an earlier one is gone.
        python: The task file that it works on, whose lines it is asked about when it hangs.
    """

    def __init__(self, name: str, folder: Path, limits: StageLimits) -> None:
        self._name, self._folder, self._limits = name, folder, limits
        self._guard = threading.Lock()
        self._child: ChildProcess | None = None
        self._channel: Channel | None = None
        self._pid: int | None = None
        self._running, self._stopped, self._closed = "", False, False
        self._asked = threading.Event()
        self.generation, self.python = 0, Path()

    @property
    def pid(self) -> int | None:
        """Number of the process, None where there is none or it has not answered yet."""
        return self._pid

    def warm(self) -> None:
        """Start the process, unless it is there; it loads its libraries while the caller goes on."""
        with self._guard:
            if self._child is not None or self._closed:
                return
            self._dump.unlink(missing_ok=True)
            self.generation += 1
            try:
                self._child = ChildProcess(HOST, [str(self._dump), str(self._limits.memory)], {OWNER: str(self._folder)})
            except OSError as error:
                problem = f"Its process could not be started: {error}. Free memory or processes."
                raise StageFault("crashed", "start", problem) from error
            self._channel = Channel(self._child.connection)

    def ask(self, operation: str, question: Mapping[str, Any], limit: float, on_note: OnNote | None = None) -> Any:
        """Ask one thing and wait for the answer.

        Args:
            operation: What it is called in errors, and in the question.
            question: Plain data.
            limit: Longest time without any message [s].
            on_note: Called for what arrives before the answer; what it raises stops the operation, and is raised here.

        Raises:
            StageFault: The process died or hung, and is ended; or it could not do it, and lives on.
            StageStopped: `stop` was called.
            NothingOpen: No task is open in it.
        """
        with self._guard:
            self._running, self._stopped, self._asked = operation, False, threading.Event()
        answered, raised = False, None
        try:
            self._make_ready(operation)
            self._send(operation, {"call": operation, **question}, limit)
            message = self._receive(operation, limit)
            while "note" in message:
                if on_note is not None and raised is None:
                    raised = self._raised_by(on_note, message)
                message = self._receive(operation, limit)
            answered = True
        finally:
            with self._guard:
                self._running = ""
            if not answered:
                self.end()
            self._asked.set()
        if raised is not None:
            raise raised
        return self._read(operation, message)

    def _raised_by(self, on_note: OnNote, message: Mapping[str, Any]) -> Exception | None:
        """Call back; when that raises, ask the process to end what it is at, and return the error."""
        try:
            on_note(message["note"], message["value"])
        except Exception as error:
            self._ask_to_stop()
            return error
        return None

    def stop(self) -> bool:
        """End what runs, from another thread; False when nothing does.

        The process is asked first, and lives on when it ends in time what it is at.
        """
        with self._guard:
            if not self._running:
                return False
            self._stopped, asked = True, self._asked
        if self._ask_to_stop() and asked.wait(_STOP_WAIT):
            return True
        self._kill()
        return True

    def _ask_to_stop(self) -> bool:
        """Ask the process to end what it is at; False where there is none."""
        if self._pid is None:
            return False
        with contextlib.suppress(OSError):
            os.kill(self._pid, signal.SIGUSR2)
        return True

    def end(self, patience: float = 0.0) -> str:
        """End the process and what it started; say how it ended, where it did so by itself."""
        how = self._kill(patience)
        with self._guard:
            self._child = self._channel = self._pid = None
        return how

    def close(self) -> None:
        """End the process for good."""
        with self._guard:
            self._closed, self._stopped = True, True
        self.end()

    # Messages --------------------------------------------------------------------------------------------------------------

    def _make_ready(self, operation: str) -> None:
        if self._pid is None:
            self.warm()
            self._pid = int(self._receive(operation, self._limits.start)["ready"])

    def _send(self, operation: str, question: Mapping[str, Any], limit: float) -> None:
        channel = self._channel
        try:
            if channel is None:
                raise EOFError
            channel.send(question, limit)
        except (EOFError, OSError) as error:
            raise self._lost(operation) from error

    def _receive(self, operation: str, limit: float) -> dict[str, Any]:
        channel = self._channel
        try:
            if channel is None:
                raise EOFError
            return channel.receive(limit)
        except TimeoutError as error:
            raise self._late(operation, limit) from error
        except (EOFError, OSError, WireError) as error:
            raise self._lost(operation) from error

    def _read(self, operation: str, message: Mapping[str, Any]) -> Any:
        if "error" not in message:
            return message.get("ok")
        kind, text = message.get("kind"), str(message["error"])
        if kind == "nothing open":
            raise NothingOpen(operation, text)
        if kind == "stopped":
            raise StageStopped(operation)
        if kind != "out of memory":
            raise StageFault("failed", operation, text, self._printed())
        self.end()
        raise StageFault("out of memory", operation, text)

    # Endings ---------------------------------------------------------------------------------------------------------------

    def _late(self, operation: str, limit: float) -> StageFault | StageStopped:
        problem = self._where(f"It did not come to an end within {limit:g} s here. Look for a loop that does not end.", ask=True)
        printed = self._printed()
        self.end()
        return self._fault("timed out", operation, f"nothing came for {limit:g} s, so it was ended.", printed, problem)

    def _lost(self, operation: str) -> StageFault | StageStopped:
        if self._stopped:
            return StageStopped(operation)
        child = self._child
        how = self.end(patience=2.0) or "The connection broke."
        printed = "" if child is None else child.printed()
        problem = self._where(f"{how} It was here.")
        return self._fault("crashed", operation, f"{how} See what it printed, and what the task file does.", printed, problem)

    def _fault(
        self, kind: FaultKind, operation: str, detail: str, printed: str, problem: Problem | None
    ) -> StageFault | StageStopped:
        return StageStopped(operation) if self._stopped else StageFault(kind, operation, detail, printed, problem)

    def _where(self, message: str, ask: bool = False) -> Problem | None:
        """Return the line of the task file at which the process is, or was when it crashed."""
        if ask and self._pid is not None:
            with contextlib.suppress(OSError):
                os.kill(self._pid, signal.SIGUSR1)
            end = time.monotonic() + _DUMP_WAIT
            while time.monotonic() < end and not self._dump_text().count("\n") > 1:
                time.sleep(0.01)
        line = dumped_line(self._dump_text(), self.python)
        return None if line is None else Problem("task", line, message)

    def _dump_text(self) -> str:
        try:
            return self._dump.read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""

    @property
    def _dump(self) -> Path:
        return self._folder / f"{self._name}.{self.generation}.stack"

    def _printed(self) -> str:
        return "" if self._child is None else self._child.printed()

    def _kill(self, patience: float = 0.0) -> str:
        child, channel = self._child, self._channel
        how = "" if child is None else child.end(patience)
        if channel is not None:
            channel.close()
        return how
