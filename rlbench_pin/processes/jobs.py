"""Jobs: items, a worker that makes the result of each, an engine that runs workers, and a journal to resume from.

The results depend neither on the engine nor on the number of its workers. Workers write no files. The process that calls
`run_jobs` stores every result before it requests the next one, so that a killed job can be resumed.
"""

from __future__ import annotations

import fcntl
import json
import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Callable, Generator, Hashable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

from rlbench_pin.errors import InvalidArgument, RlbenchPinError, storing
from rlbench_pin.values import as_whole

MAX_DEATHS = 3
"""Default number of workers that may die with one item before the item is given up."""
MAX_DEATHS_IN_A_ROW = 10
"""Number of workers that may die in a row, with no finished item in between, before the job ends."""
MAX_FAILED_STARTS = 3
"""Number of workers in a row that may die before their first item begins, before the job ends."""
_JOIN_TIMEOUT = 5.0  # [s]
_STARTED = "started"
"""First message of a worker process."""
POLL_INTERVAL = 0.5
"""Longest wait for workers before `stop` is checked again [s]."""

ItemT = TypeVar("ItemT", bound=Hashable)
ResultT = TypeVar("ResultT")
_ItemT = TypeVar("_ItemT", contravariant=True)
_ResultT = TypeVar("_ResultT", covariant=True)


class Worker(Protocol[_ItemT, _ResultT]):
    """Makes the results of items, one after the other."""

    def make(self, item: _ItemT, /) -> _ResultT:
        """Return the result of an item. The result also contains the errors of the item."""
        ...

    def close(self) -> None:
        """Free the resources that are kept between items."""
        ...


@dataclass(frozen=True)
class WorkerDeath(Generic[ItemT]):
    """A worker died and was replaced."""

    item: ItemT
    """The item that the worker was making. Another worker makes it again, unless it is given up."""
    cause: str
    """A signal or an exit code."""


@dataclass(frozen=True)
class GivenUp(Generic[ItemT]):
    """An item that is given up because too many workers died with it; it has no result."""

    item: ItemT
    cause: str


class WorkersDie(RlbenchPinError):
    """Too many workers died in a row.

    Attributes:
        causes: Signal or exit code of each worker.
    """

    def __init__(self, causes: Sequence[str]) -> None:
        self.causes = tuple(causes)
        counted = ", ".join(f"{n} x {cause}" for cause, n in Counter(causes).items())
        super().__init__(
            f"{len(causes)} workers in a row ended without finishing an item ({counted}). Check the free memory. "
            "A script that starts workers needs `if __name__ == '__main__':`. "
            "`--workers 0` runs in this process and shows the error."
        )


Events = Generator[ResultT | WorkerDeath[ItemT] | GivenUp[ItemT], None, None]


@runtime_checkable
class Engine(Protocol):
    """Runs workers."""

    def map(
        self,
        worker: Callable[[], Worker[ItemT, ResultT]],
        items: Sequence[ItemT],
        stop: threading.Event,
        max_deaths: int = MAX_DEATHS,
    ) -> Events[ResultT, ItemT]:
        """Yield the result of every item, in any order.

        Args:
            worker: Makes a worker, in the process that uses it. It must be picklable, like items and results.
            items: The items to make.
            stop: When set, no further item begins.
            max_deaths: Number of workers that may die with one item before the item is given up.
        """
        ...


class SerialEngine:
    """Runs one worker in this process."""

    def map(
        self,
        worker: Callable[[], Worker[ItemT, ResultT]],
        items: Sequence[ItemT],
        stop: threading.Event,
        max_deaths: int = MAX_DEATHS,
    ) -> Events[ResultT, ItemT]:
        """Yield the result of every item in order."""
        with closing(worker()) as only:
            for item in items:
                if stop.is_set():
                    return
                yield only.make(item)


class RetryPolicy(Generic[ItemT]):
    """Counts workers that died, and decides whether their items are made again.

    Args:
        max_deaths: Workers that may die with one item before it is given up.
    """

    def __init__(self, max_deaths: int = MAX_DEATHS) -> None:
        self.max_deaths = max_deaths
        self._per_item: Counter[ItemT] = Counter()
        self._in_a_row: list[str] = []
        self._failed_starts: list[str] = []

    def on_start(self) -> None:
        """Note that a worker is ready for its first item."""
        self._failed_starts.clear()

    def on_success(self) -> None:
        """Note that an item was finished."""
        self._in_a_row.clear()

    def on_death(self, item: ItemT, cause: str, started: bool = True) -> tuple[WorkerDeath[ItemT] | GivenUp[ItemT], ...]:
        """Note that a worker died with an item. The item is given up or made again, see `is_given_up`.

        Args:
            item: The item.
            cause: A signal or an exit code.
            started: Whether the worker was ready for its first item; otherwise its death is no fault of the item.

        Returns:
            Events for the engine to yield.
        """
        if not started:
            self._failed_starts.append(cause)
            return ()
        death = WorkerDeath(item, cause)
        self._per_item[item] += 1
        self._in_a_row.append(cause)
        if not self.is_given_up(item):
            return (death,)
        times = f": {self.max_deaths} times, the last" if self.max_deaths > 1 else ""
        return death, GivenUp(item, f"worker died{times} with {cause}")

    def is_given_up(self, item: ItemT) -> bool:
        """Whether too many workers died with an item."""
        return self._per_item[item] >= self.max_deaths

    def check(self) -> None:
        """Raise an error if too many workers died.

        Raises:
            WorkersDie: `MAX_DEATHS_IN_A_ROW` workers died with no finished item in between, or `MAX_FAILED_STARTS` workers died
                before they were ready.
        """
        if len(self._failed_starts) >= MAX_FAILED_STARTS:
            raise WorkersDie(self._failed_starts)
        if len(self._in_a_row) >= MAX_DEATHS_IN_A_ROW:
            raise WorkersDie(self._in_a_row)


class ProcessEngine:
    """Runs workers in processes of this machine. A worker that dies is replaced, and its item is made again.

    Args:
        workers: Number of processes.

    Raises:
        InvalidArgument: `workers` is not a whole number of at least 1.
    """

    def __init__(self, workers: int = 1) -> None:
        self.workers = as_whole(workers, "workers", InvalidArgument, least=1)

    def map(
        self,
        worker: Callable[[], Worker[ItemT, ResultT]],
        items: Sequence[ItemT],
        stop: threading.Event,
        max_deaths: int = MAX_DEATHS,
    ) -> Events[ResultT, ItemT]:
        """Yield each result when it is finished."""
        queue, retries = deque(items), RetryPolicy[ItemT](max_deaths)
        workers = [_Process[ItemT, ResultT](worker) for _ in range(min(self.workers, len(queue)))]
        try:
            while True:
                for idle in workers:
                    if not idle.items and queue and not stop.is_set():
                        idle.give(queue.popleft())
                if not (busy := [one for one in workers if one.items]):
                    return
                for one in _waited_for(busy):
                    if not one.started and one.has_started():
                        retries.on_start()
                        continue
                    item, results = one.take()
                    if results:
                        retries.on_success()
                        yield results[0]
                        continue
                    yield from retries.on_death(item, one.end(), one.started)
                    if not retries.is_given_up(item):
                        queue.appendleft(item)
                    retries.check()
                    workers[workers.index(one)] = _Process(worker)
        finally:
            for one in workers:
                one.stop()


def _waited_for(busy: Sequence[_Process[ItemT, ResultT]]) -> list[_Process[ItemT, ResultT]]:
    """Return the processes that have sent something or died within `POLL_INTERVAL`."""
    ready = wait([source for one in busy for source in (one.connection, one.sentinel)], POLL_INTERVAL)
    return [one for one in busy if one.connection in ready or one.sentinel in ready]


class _Process(Generic[ItemT, ResultT]):
    """A process with a worker, and the connection to it."""

    def __init__(self, worker: Callable[[], Worker[ItemT, ResultT]]) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs, worker), daemon=True)
        with _one_thread(), ignore_interrupts():
            self._process.start()
        theirs.close()
        self.sentinel = self._process.sentinel
        self.items: tuple[ItemT, ...] = ()
        """The current item, if any."""
        self.started = False
        """Whether the process has reported that its worker is ready."""

    def give(self, item: ItemT) -> None:
        """Send an item; if the process has died, `take` returns no result."""
        self.items = (item,)
        with suppress(OSError):
            self.connection.send(item)

    def has_started(self) -> bool:
        """Receive the first message, and return whether the worker is ready; False if the process has died."""
        with suppress(EOFError, OSError):
            self.started = self.connection.poll() and self.connection.recv() == _STARTED
        return self.started

    def take(self) -> tuple[ItemT, tuple[ResultT, ...]]:
        """Return the item and its result; no result if the process has died."""
        (item,), self.items = self.items, ()
        try:
            return item, (self.connection.recv(),) if self.connection.poll() else ()
        except (EOFError, OSError):
            return item, ()

    def end(self) -> str:
        """Wait for the end of a process that died, and return the signal or exit code."""
        self._process.join(_JOIN_TIMEOUT)
        self.stop()
        code = self._process.exitcode
        return signal.Signals(-code).name if code is not None and code < 0 else f"exit code {code}"

    def stop(self) -> None:
        """End the process: close the connection, which ends an idle process, and terminate a busy one."""
        self.connection.close()
        if self.items:
            self._process.terminate()
        self._process.join(_JOIN_TIMEOUT)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _work(connection: Connection, worker: Callable[[], Worker[ItemT, ResultT]]) -> None:
    """Make the results of received items, and send them, until the connection closes."""
    with closing(worker()) as only, suppress(EOFError, OSError):
        connection.send(_STARTED)
        while True:
            connection.send(only.make(connection.recv()))


@contextmanager
def _one_thread() -> Iterator[None]:
    """Start processes that use one thread each for linear algebra in this block, unless the user sets another number."""
    before = os.environ.get("OMP_NUM_THREADS")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    try:
        yield
    finally:
        if before is None:
            del os.environ["OMP_NUM_THREADS"]


@contextmanager
def ignore_interrupts() -> Iterator[None]:
    """Return a context in which started processes ignore Ctrl-C; the calling process receives Ctrl-C after the block."""
    resource_tracker.ensure_running()  # its start would unblock the signal
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def run_jobs(
    items: Sequence[ItemT],
    worker: Callable[[], Worker[ItemT, ResultT]],
    *,
    store: Callable[[ResultT], object],
    lost: Callable[[GivenUp[ItemT]], ResultT],
    engine: Engine | None = None,
    stop: threading.Event | None = None,
    max_deaths: int = MAX_DEATHS,
) -> Iterator[ResultT | WorkerDeath[ItemT]]:
    """Make the results of items. Yield each result after it is stored, and each death of a worker.

    Args:
        items: The items, without those that were finished before.
        worker: Makes a worker, in the process that uses it.
        store: Stores a result, so that the item is not made again.
        lost: Returns the result of an item that was given up.
        engine: Runs the workers; None uses one process.
        stop: When set, no further item begins; items that have begun are finished and stored.
        max_deaths: Number of workers that may die with one item before the item is given up.
    """
    with closing((engine or ProcessEngine()).map(worker, items, stop or threading.Event(), max_deaths)) as events:
        for event in events:
            if not isinstance(event, WorkerDeath):
                event = lost(event) if isinstance(event, GivenUp) else event
                store(event)
            yield event


class JournalInUse(RlbenchPinError):
    """Another process writes to a journal."""

    def __init__(self, path: Path) -> None:
        self.path = path
        super().__init__(f"Another process writes to '{path}'. Wait for it, or choose another file.")


@contextmanager
def exclusive(path: Path) -> Iterator[None]:
    """Lock a journal against other processes in this block. The system unlocks it when this process is killed.

    Raises:
        JournalInUse: Another process has locked the journal.
        StorageError: The disk cannot be written.
    """
    with storing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        file = path.open("ab")
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise JournalInUse(path) from error
        yield


class Journal:
    """A file with a JSON object per line, one line per finished item.

    Args:
        path: The file. An incomplete last line, from a writer that was killed, is removed.

    Raises:
        StorageError: The file cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        data = b""
        with storing(path):
            if path.is_file():
                data = path.read_bytes()
            if (size := data.rfind(b"\n") + 1) < len(data):
                os.truncate(path, size)
        self.lines = [_json_object(line) for line in data[:size].splitlines()]
        """The objects that the file contained; None for a damaged line."""

    def clear(self) -> None:
        """Remove all lines.

        Raises:
            StorageError: The disk cannot be written.
        """
        with storing(self.path):
            os.truncate(self.path, 0)
        self.lines = []

    def append(self, content: Mapping[str, Any]) -> None:
        """Append an object, and wait until it is on the disk.

        Raises:
            StorageError: The disk cannot be written. Lines that were appended before are complete.
        """
        with storing(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("ab") as file:
                file.write((json.dumps(content) + "\n").encode())
                file.flush()
                os.fsync(file.fileno())


def first_line(path: Path) -> dict[str, Any] | None:
    """Return the first object of a journal that another process may be writing; None if there is no such object.

    Raises:
        StorageError: The file cannot be read.
    """
    with storing(path):
        if not path.is_file():
            return None
        with path.open("rb") as file:
            return _json_object(file.readline())


def _json_object(line: bytes) -> dict[str, Any] | None:
    """Return the JSON object of a line; None if the line is damaged."""
    try:
        found = json.loads(line)
    except ValueError:
        return None
    return found if isinstance(found, dict) else None
