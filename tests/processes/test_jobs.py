"""Any work by any workers: results do not depend on who does it, and workers that die cost nothing but their pieces."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest

from rlbench_pin.errors import InvalidArgument
from rlbench_pin.processes import (
    Engine,
    GivenUp,
    Journal,
    JournalInUse,
    ProcessEngine,
    SerialEngine,
    WorkerDeath,
    WorkersDie,
    exclusive,
    run_jobs,
)
from rlbench_pin.processes.jobs import MAX_DEATHS, RetryPolicy


@dataclass(frozen=True)
class Piece:
    """A number to square, and what happens to who does it."""

    number: int
    deaths: int = 0
    """How many workers it costs."""


class Squares:
    """Squares numbers; a file counts how often each was begun, over the lives of workers.

    Args:
        folder: Where these files lie.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def make(self, piece: Piece) -> tuple[int, int]:
        """Return the number and its square, unless the piece has not cost enough yet."""
        with (self.folder / str(piece.number)).open("a+", encoding="utf-8") as file:
            file.write("x")
            file.seek(0)
            if len(file.read()) <= piece.deaths:
                file.close()
                os.kill(os.getpid(), signal.SIGKILL)
        return piece.number, piece.number**2

    def close(self) -> None:
        """Say that it was closed."""
        (self.folder / "closed").touch()


def run(engine: Engine, folder: Path, pieces: list[Piece], stop: threading.Event | None = None) -> list[object]:
    """Everything that an engine yields."""
    return list(engine.map(partial(Squares, folder), pieces, stop or threading.Event()))


def test_an_item_that_kills_is_given_up() -> None:
    """The third worker that dies of one item is the last; the others go on."""
    retries = RetryPolicy[int]()
    for _ in range(MAX_DEATHS - 1):
        for item in (0, 1):
            assert retries.on_death(item, "SIGSEGV") == (WorkerDeath(item, "SIGSEGV"),)
            assert not retries.is_given_up(item)
        retries.on_success()
    death, given_up = retries.on_death(0, "SIGSEGV")
    assert death == WorkerDeath(0, "SIGSEGV")
    assert given_up == GivenUp(0, "worker died: 3 times, the last with SIGSEGV")


def test_workers_that_only_die_end_the_work() -> None:
    """When one after the other dies without finishing anything, the error counts the causes."""
    retries = RetryPolicy[int]()
    for index in range(9):
        retries.on_death(index, "SIGKILL")
        retries.check()
    retries.on_death(9, "SIGKILL")
    with pytest.raises(WorkersDie, match="10 x SIGKILL.*--workers 0"):
        retries.check()


class Unable(Squares):
    """A worker that cannot be made."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        raise ImportError("no such library")


@pytest.mark.simulation
def test_workers_that_never_start_end_the_work(tmp_path: Path) -> None:
    """Also where there is one item; it is neither blamed nor given up."""
    with pytest.raises(WorkersDie, match="3 x exit code 1.*__main__"):
        list(ProcessEngine(1).map(partial(Unable, tmp_path), [Piece(0)], threading.Event()))


@pytest.mark.simulation
def test_an_item_may_have_a_single_try(tmp_path: Path) -> None:
    """The first death is the last."""
    events = list(ProcessEngine(1).map(partial(Squares, tmp_path), [Piece(1, deaths=1), Piece(2)], threading.Event(), 1))
    assert events == [WorkerDeath(Piece(1, 1), "SIGKILL"), GivenUp(Piece(1, 1), "worker died with SIGKILL"), (2, 4)]


@pytest.mark.simulation
@pytest.mark.parametrize("engine", [SerialEngine(), ProcessEngine(1), ProcessEngine(2)], ids=["here", "one", "two"])
def test_results_do_not_depend_on_who_works(engine: Engine, tmp_path: Path) -> None:
    """Every piece is done once, and the worker is closed."""
    assert sorted(run(engine, tmp_path, [Piece(n) for n in range(5)])) == [(n, n * n) for n in range(5)]  # type: ignore[type-var]
    assert (tmp_path / "closed").exists()
    assert multiprocessing.active_children() == []


@pytest.mark.simulation
def test_workers_that_die_are_replaced(tmp_path: Path) -> None:
    """A piece that costs two workers is done by the third, one that costs more is given up, and the rest is done."""
    cheap, dear = Piece(1, deaths=2), Piece(2, deaths=9)
    events = run(ProcessEngine(1), tmp_path, [Piece(0), cheap, Piece(3), dear, Piece(4)])
    assert [e for e in events if isinstance(e, tuple)] == [(0, 0), (1, 1), (3, 9), (4, 16)]
    assert [e for e in events if isinstance(e, WorkerDeath)] == [WorkerDeath(cheap, "SIGKILL")] * 2 + [
        WorkerDeath(dear, "SIGKILL")
    ] * 3
    assert [e.item for e in events if isinstance(e, GivenUp)] == [dear]


def test_stopping_begins_nothing(tmp_path: Path) -> None:
    """An engine that is stopped before it starts does nothing."""
    stop = threading.Event()
    stop.set()
    assert run(SerialEngine(), tmp_path, [Piece(0)], stop) == []
    assert not (tmp_path / "0").exists()


@pytest.mark.parametrize("workers", [0, -1, 1.5, "2", None])
def test_a_number_of_workers_is_checked(workers: object) -> None:
    """It is a whole number from 1 on."""
    with pytest.raises(InvalidArgument, match="workers"):
        ProcessEngine(workers)  # type: ignore[arg-type]


@pytest.mark.simulation
def test_results_are_stored_before_they_are_told(tmp_path: Path) -> None:
    """Also what is known of an item that no worker survives; the workers that died are told too."""
    stored: list[tuple[int, int]] = []
    told: list[WorkerDeath[Piece] | tuple[int, int]] = []
    pieces, worker = [Piece(0), Piece(1, deaths=9), Piece(2)], partial(Squares, tmp_path)
    for event in run_jobs(pieces, worker, store=stored.append, lost=lambda lost: (lost.item.number, -1)):
        assert isinstance(event, WorkerDeath) or stored[-1] == event
        told.append(event)
    assert stored == [(0, 0), (1, -1), (2, 4)]
    assert [event for event in told if isinstance(event, WorkerDeath)] == [WorkerDeath(pieces[1], "SIGKILL")] * MAX_DEATHS


def test_a_job_that_raises_closes_its_worker(tmp_path: Path) -> None:
    """So does an interrupt between two results."""
    events = run_jobs([Piece(0), Piece(1)], partial(Squares, tmp_path), store=print, lost=pytest.fail, engine=SerialEngine())
    assert next(events) == (0, 0)
    with pytest.raises(KeyboardInterrupt):
        events.throw(KeyboardInterrupt)  # type: ignore[attr-defined]
    assert (tmp_path / "closed").exists()


def test_a_journal_keeps_whole_lines(tmp_path: Path) -> None:
    """A line that was being written is cut off, a damaged one is None, and lines are appended behind."""
    path = tmp_path / "folder" / "journal.jsonl"
    assert Journal(path).lines == []
    assert not path.exists()
    Journal(path).append({"a": 1.5})
    path.write_bytes(path.read_bytes() + b"[]\n\xff\n" + b'{"half')
    journal = Journal(path)
    assert journal.lines == [{"a": 1.5}, None, None]
    journal.append({"b": 2})
    assert Journal(path).lines == [{"a": 1.5}, None, None, {"b": 2}]


def test_one_process_writes_to_a_journal(tmp_path: Path) -> None:
    """Until its block ends."""
    path = tmp_path / "journal.jsonl"
    with exclusive(path), pytest.raises(JournalInUse, match="Another process"), exclusive(path):
        pass
    with exclusive(path):
        pass
