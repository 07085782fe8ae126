"""Work items -> trials, in this process or in several; finished ones are kept in a journal."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection

from rlbench_pin.checking.journal import TrialJournal
from rlbench_pin.checking.records import Trial
from rlbench_pin.checking.trials import Item, work
from rlbench_pin.errors import RlbenchPinError
from rlbench_pin.processes import deaf_to_interrupts
from rlbench_pin.values import as_function, as_record, as_several, as_whole

MOST_WORKERS = 1024


@dataclass(frozen=True)
class CheckProgress:
    """How far a check is."""

    total: int
    """Trials of the whole check."""
    found: int
    """Trials that the journal held at the start."""
    done: int
    """Trials done now."""
    latest: Item | None = None
    """The item that was finished last, None at the start."""


def run_trials(
    items: Sequence[Item], workers: int, journal: TrialJournal, on_progress: Callable[[CheckProgress], None] | None = None
) -> list[Trial]:
    """Do what the journal does not hold yet, write it there, and return the trials of all items.

    Args:
        items: The work.
        workers: Processes; the result does not depend on their number.
        journal: What was done before.
        on_progress: Called once before the work begins, and after each item.

    Raises:
        InvalidValue: An argument is not what it has to be; nothing was done.
        RlbenchPinError: A worker died.
    """
    items = [as_record(item, Item, "an entry of items") for item in as_several(items, "items")]
    workers = as_whole(workers, "workers", least=1, most=MOST_WORKERS)
    as_record(journal, TrialJournal, "journal")
    as_function(on_progress, "on_progress")
    trials: list[Trial] = []
    todo = []
    for item in items:
        known = journal.trials_of(item)
        if known is None:
            todo.append(item)
        else:
            trials += known
    total = _count(items)
    progress = CheckProgress(total, total - _count(todo), 0)
    report = on_progress or (lambda _: None)
    report(progress)
    for item, made in _results(todo, workers):
        journal.add(item, made)
        trials += made
        progress = replace(progress, done=progress.done + len(item.seeds), latest=item)
        report(progress)
    return trials


def _count(items: Sequence[Item]) -> int:
    return sum(len(item.seeds) for item in items)


def _results(items: Sequence[Item], workers: int) -> Iterator[tuple[Item, list[Trial]]]:
    if workers == 1 or len(items) < 2:
        yield from ((item, work(item)) for item in items)
        return
    context = multiprocessing.get_context("spawn")
    theirs, ours = context.Pipe(duplex=False)
    with theirs, ours, ProcessPoolExecutor(workers, context, _end_with_connection, (theirs,)) as pool:
        try:
            with deaf_to_interrupts():  # submitting starts the workers
                futures = {pool.submit(work, item): item for item in items}
            for future in as_completed(futures):
                yield futures[future], _result(future, futures[future])
        except BaseException:
            ours.close()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _end_with_connection(connection: Connection) -> None:
    """End this worker as soon as nobody holds the other end of a connection: its owner gave up, or was killed."""

    def watch() -> None:
        with suppress(EOFError, OSError):
            connection.recv()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _result(future: Future[list[Trial]], item: Item) -> list[Trial]:
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise RlbenchPinError(
            f"A worker died, at or near '{item.part}' of '{item.task}'; perhaps memory ran out. "
            "With --out, the same command goes on from here."
        ) from error
