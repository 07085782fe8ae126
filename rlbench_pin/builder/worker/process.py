"""A worker process in the server of the builder: its files, limits, errors, requests and answers."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from rlbench_pin.builder.contracts import TaskText
from rlbench_pin.builder.worker.problems import dumped_line
from rlbench_pin.errors import InvalidValue, RlbenchPinError
from rlbench_pin.evaluation.policies.policy_server import Channel, WireError
from rlbench_pin.processes.child import ChildProcess
from rlbench_pin.values import POSITIVE, check_settings, counted, ruled
from rlbench_pin.viewer.recording import Problem

# Errors -----------------------------------------------------------------------------------------------------------------------

FaultKind = Literal["crashed", "timed out", "out of memory", "failed"]
"""Kind of a failed operation; after `failed` the process continues."""
_SENTENCES: dict[FaultKind, str] = {
    "crashed": "died",
    "timed out": "did not answer in time",
    "out of memory": "ran out of memory",
    "failed": "failed",
}


class WorkerFault(RlbenchPinError):
    """The worker process failed in an operation. The next operation starts a new process and opens the task again.

    Args:
        kind: How it failed.
        operation: Name of the operation.
        detail: What happened, and the next step.
        printed: The last lines that the process printed.
        problem: The line of the task at which it happened, if known.
    """

    def __init__(self, kind: FaultKind, operation: str, detail: str, printed: str = "", problem: Problem | None = None) -> None:
        self.kind: FaultKind = kind
        self.operation, self.detail, self.printed, self.problem = operation, detail, printed, problem
        where = "" if problem is None or problem.line is None else f" It was at line {problem.line} of the {problem.file} file."
        ending = f"\nIt printed last:\n{printed}" if printed else ""
        super().__init__(f"The simulation {_SENTENCES[kind]} during `{operation}`: {detail}{where}{ending}")


class WorkerStopped(RlbenchPinError):
    """An operation was ended by `cancel`."""

    def __init__(self, operation: str) -> None:
        self.operation = operation
        super().__init__(f"`{operation}` was stopped by `cancel()`. Call it again.")


class WorkerBusy(RlbenchPinError):
    """Another operation runs; nothing was done."""

    def __init__(self, operation: str, running: str) -> None:
        self.operation, self.running = operation, running
        super().__init__(f"`{operation}` has to wait until `{running}` is done. Wait for it, or `cancel()` it.")


class NothingOpen(RlbenchPinError):
    """No task is open, or the open task cannot be built."""

    def __init__(self, operation: str, why: str = "no task was opened. Call `open` first.") -> None:
        self.operation = operation
        super().__init__(f"`{operation}` needs an open task: {why}")


class WorkerClosed(RlbenchPinError):
    """The client was closed."""

    def __init__(self, operation: str) -> None:
        self.operation = operation
        super().__init__(f"`{operation}` was called on a closed client. Create a new WorkerClient.")


# Limits -----------------------------------------------------------------------------------------------------------------------

_TIMES = "start open reset place reach follow paths image tick trial wait"
_RULES = ruled((POSITIVE, _TIMES), (counted(2**28, 2**50), "memory"))


@dataclass(frozen=True, kw_only=True)
class WorkerLimits:
    """Time limits [s] of the operations, after which the process is ended, and its memory limit."""

    start: float = 60.0
    """Time limit for the start of a process until its libraries are loaded."""
    open: float = 20.0
    """Time limit for building a task."""
    reset: float = 20.0
    """Time limit for each layout that is tried for an episode."""
    place: float = 10.0
    """Time limit for new poses of a scene."""
    reach: float = 5.0
    """Time limit for checking the reachability of all waypoints."""
    follow: float = 5.0
    """Time limit for one step of the arm towards a dragged gripper."""
    paths: float = 60.0
    """Time limit for planning the path to one waypoint."""
    image: float = 20.0
    """Time limit for the images of all cameras."""
    tick: float = 60.0
    """Time limit between two frames of a demonstration, for planning a motion or one control tick."""
    trial: float = 600.0
    """Time limit for one trial of the validator."""
    wait: float = 5.0
    """Maximum time to wait for the end of the previous operation; then the next operation raises WorkerBusy."""
    memory: int = 4 * 2**30
    """Maximum address space of a task, in addition to that of the libraries [byte]."""

    def __post_init__(self) -> None:
        """Raise InvalidValue for a number that is NaN, of a wrong kind, or not above 0 (also a ValueError)."""
        check_settings(self, _RULES)


# Files ------------------------------------------------------------------------------------------------------------------------

_NAME = re.compile(r"[a-z][a-z0-9_]*")
_RELATIVE_PATH = re.compile(r"""["'](\.\.?/[^"']*)["']""")
"""Relative paths in a scene."""
OWNER = "RLBENCH_PIN_BUILDER"
"""Environment variable of a worker process and its descendants; its value is the private folder."""
_SWEEP = """read -r _
for turn in 1 2 3; do
    grep -lsaF -- "$2=$1" /proc/[0-9]*/environ | while IFS=/ read -r _ _ number _; do kill -9 "$number"; done
done
rm -rf -- "$1"
"""
"""Program of the sweeper: wait for the end of its input, end remaining worker processes, remove the folder."""


class PrivateFolder:
    """A temporary folder for the files of the edited task. A small process removes it when the owner closes it or is killed.

    That process also ends descendants of the workers that left their process group.

    Attributes:
        path: The folder.
    """

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="rlbench_pin_builder_")).resolve()
        self._sweeper = subprocess.Popen(
            ["/bin/sh", "-c", _SWEEP, "sh", str(self.path), OWNER],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd="/", start_new_session=True,
        )  # fmt: skip

    def write(self, part: str, text: TaskText) -> Path:
        """Write a task into a part of the folder, with links to the other files in the real folder.

        Args:
            part: Name of the part, which is emptied first.
            text: The task.

        Returns:
            The Python file; its scene is in the same folder.

        Raises:
            InvalidValue: The name of the task is not valid.
        """
        check_name(text.name)
        here = self.path / part
        shutil.rmtree(here, ignore_errors=True)
        here.mkdir()
        pair = (f"{text.name}.toml", f"{text.name}.py")
        levels = max((found.count("../") for found in _RELATIVE_PATH.findall(text.scene)), default=0)
        folder = text.folder.absolute()
        way = [*reversed(list(folder.parents)[:levels]), folder]  # the scene names files in these folders
        for above, below in zip(way, way[1:]):
            _link_entries(above, here, [below.name])
            here = here / (below.name or "root")
            here.mkdir()
        _link_entries(way[-1], here, pair)
        for name, content in zip(pair, (text.scene, text.python), strict=True):
            (here / name).write_text(content, encoding="utf-8")
        return here / pair[1]

    def update(self, python: Path, before: TaskText, text: TaskText) -> Path:
        """Write a task again of which only the scene has changed, and return its Python file."""
        if _RELATIVE_PATH.findall(before.scene) != _RELATIVE_PATH.findall(text.scene) or not python.is_file():
            return self.write(python.relative_to(self.path).parts[0], text)
        python.with_suffix(".toml").write_text(text.scene, encoding="utf-8")
        return python

    def close(self) -> None:
        """Remove the folder; repeated calls have no effect."""
        if self._sweeper.stdin is not None and not self._sweeper.stdin.closed:
            with contextlib.suppress(OSError), self._sweeper.stdin as pipe:
                pipe.write(b"\n")  # a forked process may hold the pipe, too: do not rely on its end
            self._sweeper.wait(timeout=30.0)


def check_name(name: str) -> None:
    """Raise InvalidValue unless a name is a valid name of a task; files are named after it."""
    if not _NAME.fullmatch(name):
        raise InvalidValue("The name of a task", name, "has to be small letters, digits and `_`, a letter first")


def _link_entries(folder: Path, into: Path, leave_out: Iterable[str]) -> None:
    left = set(leave_out)
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name not in left:
                os.symlink(entry.path, into / entry.name)


# The process ------------------------------------------------------------------------------------------------------------------

_MODULE = "rlbench_pin.builder.worker.host"
_DUMP_WAIT = 0.5
"""Time that a process that hangs has to dump its stack [s]."""
_STOP_WAIT = 1.0
"""Time that a process has to stop an operation by itself [s]."""
OnNote = Callable[[str, Any], None]
"""Called with name and content of each message before the answer."""


class WorkerProcess:
    """A process that answers one request at a time. It is started when needed, also after it has died.

    Args:
        name: Name of its files.
        folder: The private folder.
        limits: Times and memory.

    Attributes:
        generation: Number of processes so far; the state of earlier ones is lost.
        python: The task file that it works on.
        pid: Process id; None before it has answered.
        running: Name of the current operation, or empty.
    """

    def __init__(self, name: str, folder: Path, limits: WorkerLimits) -> None:
        self._name, self._folder, self._limits = name, folder, limits
        self._lock, self._turn, self._turn_thread = threading.Lock(), threading.Lock(), 0
        self._child: ChildProcess | None = None
        self._channel: Channel | None = None
        self.pid: int | None = None
        self._asking, self._stopped, self._closed = "", False, False
        self._answered = threading.Event()
        self.generation, self.python, self.running = 0, Path(), ""

    @contextmanager
    def turn(self, operation: str) -> Iterator[None]:
        """Reserve the process for a block.

        Raises:
            WorkerBusy: Another operation did not end in time, or a callback of the current one asks.
        """
        thread = threading.get_ident()
        if self._turn_thread == thread or not self._turn.acquire(timeout=self._limits.wait):
            raise WorkerBusy(operation, self.running)
        self.running, self._turn_thread = operation, thread
        try:
            yield
        finally:
            self.running, self._turn_thread = "", 0
            self._turn.release()

    def start(self) -> None:
        """Start the process unless it runs; it loads its libraries while the caller goes on."""
        with self._lock:
            if self._child is not None or self._closed:
                return
            self._dump.unlink(missing_ok=True)
            self.generation += 1
            arguments = (str(self._dump), str(self._limits.memory))
            try:
                self._child = ChildProcess(_MODULE, arguments, {OWNER: str(self._folder)})
            except OSError as error:
                detail = f"Its process could not be started: {error}. Free memory or processes."
                raise WorkerFault("crashed", "start", detail) from error
            self._channel = Channel(self._child.connection)

    def ask(self, operation: str, question: Mapping[str, Any], limit: float, on_note: OnNote | None = None) -> Any:
        """Send a request and wait for the answer.

        Args:
            operation: Name of the operation.
            question: Arguments of the operation, plain data.
            limit: Longest time without any message [s].
            on_note: Called for each message before the answer; an exception stops the operation and is raised here.

        Raises:
            WorkerFault: The process died, hung, or failed.
            WorkerStopped: `stop` was called.
            NothingOpen: No task is open in it.
        """
        with self._lock:
            self._asking, self._stopped, self._answered = operation, False, threading.Event()
        raised: Exception | None = None
        try:
            if self.pid is None:
                self.start()
                self.pid = int(self._receive(operation, self._limits.start)["ready"])
            self._send(operation, {"call": operation, **question}, limit)
            while "note" in (message := self._receive(operation, limit)):
                if on_note is not None and raised is None:
                    try:
                        on_note(message["note"], message["value"])
                    except Exception as error:
                        raised = error
                        self._signal(signal.SIGUSR2)
        except BaseException:
            self.end()
            raise
        finally:
            with self._lock:
                self._asking = ""
            self._answered.set()
        if raised is not None:
            raise raised
        return self._read(operation, message)

    def stop(self) -> bool:
        """End the current operation, from another thread; return False if there is none.

        The process is asked first, and lives on if it stops in time.
        """
        with self._lock:
            if not self._asking:
                return False
            self._stopped, answered = True, self._answered
        if not (self._signal(signal.SIGUSR2) and answered.wait(_STOP_WAIT)):
            self._end_child()
        return True

    def end(self, patience: float = 0.0) -> str:
        """End the process and its descendants, and return how it ended if it did so by itself."""
        how = self._end_child(patience)
        with self._lock:
            self._child = self._channel = self.pid = None
        return how

    def close(self) -> None:
        """End the process for good."""
        with self._lock:
            self._closed, self._stopped = True, True
        self.end()

    def _end_child(self, patience: float = 0.0) -> str:
        child, channel = self._child, self._channel
        how = "" if child is None else child.end(patience)
        if channel is not None:
            channel.close()
        return how

    def _signal(self, number: signal.Signals) -> bool:
        """Send a signal; return False if there is no process that has answered."""
        if self.pid is None:
            return False
        with contextlib.suppress(OSError):
            os.kill(self.pid, number)
        return True

    # Messages -----------------------------------------------------------------------------------------------------------------

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
            raise WorkerStopped(operation)
        if kind != "out of memory":
            raise WorkerFault("failed", operation, text, self._printed())
        self.end()
        raise WorkerFault("out of memory", operation, text)

    def _late(self, operation: str, limit: float) -> RlbenchPinError:
        if self._signal(signal.SIGUSR1):  # it dumps its stack
            end = time.monotonic() + _DUMP_WAIT
            while time.monotonic() < end and not self._dump_text().count("\n") > 1:
                time.sleep(0.01)
        problem = self._problem(f"It did not come to an end within {limit:g} s here. Look for a loop that does not end.")
        printed = self._printed()
        self.end()
        detail = f"no message came for {limit:g} s, so it was ended."
        return WorkerStopped(operation) if self._stopped else WorkerFault("timed out", operation, detail, printed, problem)

    def _lost(self, operation: str) -> RlbenchPinError:
        if self._stopped:
            return WorkerStopped(operation)
        child = self._child
        how = self.end(patience=2.0) or "The connection broke."
        printed = "" if child is None else child.printed()
        detail = f"{how} See what it printed, and what the task file does."
        problem = self._problem(f"{how} It was here.")
        return WorkerStopped(operation) if self._stopped else WorkerFault("crashed", operation, detail, printed, problem)

    def _problem(self, message: str) -> Problem | None:
        """Return the line of the task file in the dump of the stack."""
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
