"""map(pieces of work) -> episodes, here or in processes of this machine. The episodes do not depend on which."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Protocol, runtime_checkable

from rlbench_pin.errors import InvalidArgument, RlbenchPinError
from rlbench_pin.processes import deaf_to_interrupts
from rlbench_pin.recording.config import PictureConfig, WorkItem
from rlbench_pin.recording.work import ItemResult, Recorder
from rlbench_pin.values import as_whole

MAX_DEATHS = 3
"""Workers that one piece of work may cost before it is given up."""
MAX_DEATHS_IN_A_ROW = 10
"""Workers that may die one after the other, with nothing finished, before the recording ends."""
_JOIN_TIMEOUT = 5.0  # [s]
POLL_INTERVAL = 0.5
"""Longest wait for workers before stopping is considered again [s]."""


@dataclass(frozen=True)
class WorkerDeath:
    """A worker ended in the middle of its work and was replaced."""

    item: WorkItem
    """What it was doing; it is done again."""
    cause: str
    """A signal or an exit code."""


class WorkersDie(RlbenchPinError):
    """Worker after worker ends without finishing anything."""

    def __init__(self, deaths: Sequence[WorkerDeath]) -> None:
        self.deaths = tuple(deaths)
        causes = ", ".join(f"{n} x {c}" for c, n in Counter(d.cause for d in deaths).items())
        super().__init__(
            f"{len(deaths)} workers in a row ended without finishing anything ({causes}). Is there enough memory? "
            "A script that records needs `if __name__ == '__main__':`. `--workers 0` works in this process and shows the error."
        )


Event = ItemResult | WorkerDeath


@runtime_checkable
class Engine(Protocol):
    """Something that does pieces of work."""

    def map(self, config: PictureConfig, items: Sequence[WorkItem], stop: threading.Event) -> Generator[Event, None, None]:
        """Yield the result of every item, in any order; after `stop` only those that had begun."""
        ...


class SerialEngine:
    """Works in this process, one piece after the other."""

    def map(self, config: PictureConfig, items: Sequence[WorkItem], stop: threading.Event) -> Generator[Event, None, None]:
        """Yield the result of every item in order."""
        recorder = Recorder(config)
        try:
            for item in items:
                if stop.is_set():
                    return
                yield recorder.make(item)
        finally:
            recorder.close()


class RetryPolicy:
    """Counts workers that died, and decides whether what they were doing is tried again."""

    def __init__(self) -> None:
        self._per_item: Counter[tuple[str, int, int]] = Counter()
        self._in_a_row: list[WorkerDeath] = []

    def on_success(self) -> None:
        """Note that a piece of work was finished."""
        self._in_a_row.clear()

    def on_death(self, item: WorkItem, cause: str) -> tuple[WorkerDeath, ItemResult | None]:
        """Note that a worker died; return that, and the result of the item when it is given up.

        Args:
            item: What the worker was doing.
            cause: A signal, an exit code or an exception.

        Raises:
            WorkersDie: `MAX_DEATHS_IN_A_ROW` have died with nothing finished in between.
        """
        death = WorkerDeath(item, cause)
        self._per_item[item.key] += 1
        self._in_a_row.append(death)
        if len(self._in_a_row) >= MAX_DEATHS_IN_A_ROW:
            raise WorkersDie(self._in_a_row)
        if self._per_item[item.key] < MAX_DEATHS:
            return death, None
        return death, ItemResult(item, (f"worker died: {MAX_DEATHS} times, the last with {cause}",))


class ProcessEngine:
    """Works in processes of their own; one that dies is replaced and its piece done again.

    Args:
        workers: How many.

    Raises:
        InvalidArgument: That is no whole number from 1 on.
    """

    def __init__(self, workers: int = 1) -> None:
        self.workers = as_whole(workers, "workers", InvalidArgument, least=1)

    def map(self, config: PictureConfig, items: Sequence[WorkItem], stop: threading.Event) -> Generator[Event, None, None]:
        """Yield results as they come."""
        queue, retries = deque(items), RetryPolicy()
        workers = [_Worker(config) for _ in range(min(self.workers, len(queue)))]
        try:
            while True:
                for worker in workers:
                    if worker.item is None and queue and not stop.is_set():
                        worker.give(queue.popleft())
                if not (busy := [worker for worker in workers if worker.item is not None]):
                    return
                ready = wait([thing for worker in busy for thing in (worker.connection, worker.sentinel)], POLL_INTERVAL)
                for worker in busy:
                    if worker.connection not in ready and worker.sentinel not in ready:
                        continue
                    item, result = worker.take()
                    if result is not None:
                        retries.on_success()
                        yield result
                        continue
                    workers[workers.index(worker)] = _Worker(config)
                    death, given_up = retries.on_death(item, worker.end())
                    yield death
                    if given_up is not None:
                        yield given_up
                    else:
                        queue.appendleft(item)
        finally:
            for worker in workers:
                worker.stop()


class _Worker:
    """One process and the connection to it."""

    def __init__(self, config: PictureConfig) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs, config), daemon=True)
        with _one_thread(), deaf_to_interrupts():
            self._process.start()
        theirs.close()
        self.sentinel = self._process.sentinel
        self.item: WorkItem | None = None

    def give(self, item: WorkItem) -> None:
        """Assign a piece of work; if the process has died, `take` finds out."""
        self.item = item
        with suppress(OSError):
            self.connection.send(item)

    def take(self) -> tuple[WorkItem, ItemResult | None]:
        """Return its piece of work and the result, None when it died."""
        item, self.item = self.item, None
        assert item is not None
        try:
            return item, self.connection.recv() if self.connection.poll() else None
        except (EOFError, OSError):
            return item, None

    def end(self) -> str:
        """Wait for its end, and return why it ended."""
        self._process.join(_JOIN_TIMEOUT)
        self.stop()
        code = self._process.exitcode
        return signal.Signals(-code).name if code is not None and code < 0 else f"exit code {code}"

    def stop(self) -> None:
        """End the process: closing the connection ends an idle one, a busy one is terminated."""
        self.connection.close()
        if self.item is not None:
            self._process.terminate()
        self._process.join(_JOIN_TIMEOUT)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _work(connection: Connection, config: PictureConfig) -> None:
    """Do what comes along the connection until it closes. Ctrl-C is left to the process at its other end."""
    recorder = Recorder(config)
    with suppress(EOFError, OSError):
        while True:
            connection.send(recorder.make(connection.recv()))
    recorder.close()


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes that start in this block use one thread each for linear algebra, unless the user says otherwise."""
    before = os.environ.get("OMP_NUM_THREADS")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    try:
        yield
    finally:
        if before is None:
            del os.environ["OMP_NUM_THREADS"]
