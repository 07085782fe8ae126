"""map(workers, pieces of work) -> results, here or in processes of this machine. The results do not depend on which."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Callable, Generator, Hashable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Generic, Protocol, TypeVar, runtime_checkable

from rlbench_pin.errors import InvalidArgument, RlbenchPinError
from rlbench_pin.processes.interrupts import deaf_to_interrupts
from rlbench_pin.values import as_whole

MAX_DEATHS = 3
"""Workers that one piece of work may cost before it is given up."""
MAX_DEATHS_IN_A_ROW = 10
"""Workers that may die one after the other, with nothing finished, before the whole work ends."""
_JOIN_TIMEOUT = 5.0  # [s]
POLL_INTERVAL = 0.5
"""Longest wait for workers before stopping is considered again [s]."""

ItemT = TypeVar("ItemT", bound=Hashable)
ResultT = TypeVar("ResultT")
_TakenT = TypeVar("_TakenT", contravariant=True)
_MadeT = TypeVar("_MadeT", covariant=True)


class Worker(Protocol[_TakenT, _MadeT]):
    """Does one piece of work after the other."""

    def make(self, item: _TakenT, /) -> _MadeT:
        """Do one piece of work. What goes wrong in it belongs into the result."""
        ...

    def close(self) -> None:
        """Free what it keeps between pieces."""
        ...


@dataclass(frozen=True)
class WorkerDeath(Generic[ItemT]):
    """A worker ended in the middle of its work and was replaced."""

    item: ItemT
    """What it was doing; it is done again."""
    cause: str
    """A signal or an exit code."""


@dataclass(frozen=True)
class GivenUp(Generic[ItemT]):
    """A piece of work that ended worker after worker, and is not done."""

    item: ItemT
    """What was to be done."""
    cause: str
    """What happened."""


class WorkersDie(RlbenchPinError):
    """Worker after worker ends without finishing anything."""

    def __init__(self, deaths: Sequence[WorkerDeath]) -> None:
        self.deaths = tuple(deaths)
        causes = ", ".join(f"{n} x {c}" for c, n in Counter(d.cause for d in deaths).items())
        super().__init__(
            f"{len(deaths)} workers in a row ended without finishing anything ({causes}). Is there enough memory? "
            "A script that starts workers needs `if __name__ == '__main__':`. "
            "`--workers 0` works in this process and shows the error."
        )


@runtime_checkable
class Engine(Protocol):
    """Something that does pieces of work."""

    def map(
        self, worker: Callable[[], Worker[ItemT, ResultT]], items: Sequence[ItemT], stop: threading.Event
    ) -> Generator[ResultT | WorkerDeath[ItemT] | GivenUp[ItemT], None, None]:
        """Yield the result of every item, in any order; after `stop` only those that had begun.

        Args:
            worker: Makes a worker, in the process that is to use it; it can be pickled, as items and results can.
            items: What to do.
            stop: When set, nothing more is begun.
        """
        ...


class SerialEngine:
    """Works in this process, one piece after the other."""

    def map(
        self, worker: Callable[[], Worker[ItemT, ResultT]], items: Sequence[ItemT], stop: threading.Event
    ) -> Generator[ResultT | WorkerDeath[ItemT] | GivenUp[ItemT], None, None]:
        """Yield the result of every item in order."""
        here = worker()
        try:
            for item in items:
                if stop.is_set():
                    return
                yield here.make(item)
        finally:
            here.close()


class RetryPolicy(Generic[ItemT]):
    """Counts workers that died, and decides whether what they were doing is tried again."""

    def __init__(self) -> None:
        self._per_item: Counter[ItemT] = Counter()
        self._in_a_row: list[WorkerDeath[ItemT]] = []

    def on_success(self) -> None:
        """Note that a piece of work was finished."""
        self._in_a_row.clear()

    def on_death(self, item: ItemT, cause: str) -> tuple[WorkerDeath[ItemT], GivenUp[ItemT] | None]:
        """Note that a worker died; return that, and what becomes of the item when it is given up.

        Args:
            item: What the worker was doing.
            cause: A signal, an exit code or an exception.

        Raises:
            WorkersDie: `MAX_DEATHS_IN_A_ROW` have died with nothing finished in between.
        """
        death = WorkerDeath(item, cause)
        self._per_item[item] += 1
        self._in_a_row.append(death)
        if len(self._in_a_row) >= MAX_DEATHS_IN_A_ROW:
            raise WorkersDie(self._in_a_row)
        if self._per_item[item] < MAX_DEATHS:
            return death, None
        return death, GivenUp(item, f"worker died: {MAX_DEATHS} times, the last with {cause}")


class ProcessEngine:
    """Works in processes of their own; one that dies is replaced and its piece done again.

    Args:
        workers: How many.

    Raises:
        InvalidArgument: That is no whole number from 1 on.
    """

    def __init__(self, workers: int = 1) -> None:
        self.workers = as_whole(workers, "workers", InvalidArgument, least=1)

    def map(
        self, worker: Callable[[], Worker[ItemT, ResultT]], items: Sequence[ItemT], stop: threading.Event
    ) -> Generator[ResultT | WorkerDeath[ItemT] | GivenUp[ItemT], None, None]:
        """Yield results as they come."""
        queue, retries = deque(items), RetryPolicy[ItemT]()
        workers = [_Process[ItemT, ResultT](worker) for _ in range(min(self.workers, len(queue)))]
        try:
            while True:
                for idle in workers:
                    if not idle.items and queue and not stop.is_set():
                        idle.give(queue.popleft())
                if not (busy := [one for one in workers if one.items]):
                    return
                ready = wait([thing for one in busy for thing in (one.connection, one.sentinel)], POLL_INTERVAL)
                for one in busy:
                    if one.connection not in ready and one.sentinel not in ready:
                        continue
                    item, results = one.take()
                    if results:
                        retries.on_success()
                        yield results[0]
                        continue
                    workers[workers.index(one)] = _Process(worker)
                    death, given_up = retries.on_death(item, one.end())
                    yield death
                    if given_up is not None:
                        yield given_up
                    else:
                        queue.appendleft(item)
        finally:
            for one in workers:
                one.stop()


class _Process(Generic[ItemT, ResultT]):
    """One process and the connection to it."""

    def __init__(self, worker: Callable[[], Worker[ItemT, ResultT]]) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs, worker), daemon=True)
        with _one_thread(), deaf_to_interrupts():
            self._process.start()
        theirs.close()
        self.sentinel = self._process.sentinel
        self.items: tuple[ItemT, ...] = ()
        """What it is doing: one piece of work, or none."""

    def give(self, item: ItemT) -> None:
        """Assign a piece of work; if the process has died, `take` finds out."""
        self.items = (item,)
        with suppress(OSError):
            self.connection.send(item)

    def take(self) -> tuple[ItemT, tuple[ResultT, ...]]:
        """Return its piece of work and the result; none when it died."""
        (item,), self.items = self.items, ()
        try:
            return item, (self.connection.recv(),) if self.connection.poll() else ()
        except (EOFError, OSError):
            return item, ()

    def end(self) -> str:
        """Wait for its end, and return why it ended."""
        self._process.join(_JOIN_TIMEOUT)
        self.stop()
        code = self._process.exitcode
        return signal.Signals(-code).name if code is not None and code < 0 else f"exit code {code}"

    def stop(self) -> None:
        """End the process: closing the connection ends an idle one, a busy one is terminated."""
        self.connection.close()
        if self.items:
            self._process.terminate()
        self._process.join(_JOIN_TIMEOUT)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _work(connection: Connection, worker: Callable[[], Worker[ItemT, ResultT]]) -> None:
    """Do what comes along the connection until it closes. Ctrl-C is left to the process at its other end."""
    here = worker()
    with suppress(EOFError, OSError):
        while True:
            connection.send(here.make(connection.recv()))
    here.close()


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
