"""Work items -> trials, in this process or in several, with a bar and a journal."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool

from tqdm import tqdm

from rlbench_pin.checking.journal import Journal
from rlbench_pin.checking.trials import Item, Trial, work
from rlbench_pin.errors import RlbenchPinError


def do_all(items: Sequence[Item], workers: int, journal: Journal) -> list[Trial]:
    """Do what the journal does not hold yet, write it there, and return the trials of all items.

    Raises:
        RlbenchPinError: A worker died.
    """
    trials: list[Trial] = []
    todo = []
    with tqdm(total=sum(len(item.seeds) for item in items), unit="trial", desc="check", smoothing=0.05) as bar:
        for item in items:
            done = journal.trials_of(item)
            if done is None:
                todo.append(item)
                continue
            trials += done
            bar.update(len(item.seeds))
        bar.unpause()
        for item, done in _results(todo, workers):
            journal.add(item, done)
            trials += done
            bar.set_postfix_str(f"{done[0].task if done else item.task} {item.part}", refresh=False)
            bar.update(len(item.seeds))
    return trials


def _results(items: Sequence[Item], workers: int) -> Iterator[tuple[Item, list[Trial]]]:
    if workers == 1 or len(items) < 2:
        yield from ((item, work(item)) for item in items)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, _die_with_parent) as pool:
        futures = {pool.submit(work, item): item for item in items}
        try:
            for future in as_completed(futures):
                yield futures[future], _result(future, futures[future])
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _die_with_parent() -> None:
    """End this worker when the process that started it is killed; else it would wait for work for ever."""
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
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
