"""One thread does what a page asks for: the latest wish counts, and errors end nothing."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from rlbench_pin.viewer.job_thread import Interrupted, JobThread

PATIENCE = 10.0


@pytest.fixture
def errors() -> list[Exception]:
    """What went wrong."""
    return []


@pytest.fixture
def worker(errors: list[Exception]) -> Iterator[JobThread]:
    """A thread."""
    made = JobThread("jobs", errors.append)
    yield made
    made.stop()


def test_what_waits_is_done_once_as_it_was_asked_last(worker: JobThread) -> None:
    """Images of ten instants that were passed by are not wanted any more."""
    gate, done = threading.Event(), list[int]()

    def wait() -> None:
        gate.wait(PATIENCE)

    worker.post(wait, "wait")
    for number in range(10):
        worker.post(lambda number=number: done.append(number), "look")  # type: ignore[misc]
    gate.set()
    assert worker.wait(PATIENCE)
    assert done == [9]


def test_long_work_ends_when_something_else_is_wanted(worker: JobThread, errors: list[Exception]) -> None:
    """It ends at its next check, what waited is left out, and that is no error."""
    began, done = threading.Event(), list[str]()

    def long() -> None:
        began.set()
        while not done:
            worker.check()

    worker.post(long, "long")
    worker.post(lambda: done.append("look"), "look")
    assert began.wait(PATIENCE)
    worker.post(lambda: done.append("reset"), "reset", instead=True)
    assert worker.wait(PATIENCE)
    assert done == ["reset"]
    assert errors == []


def test_an_error_is_told_and_the_next_is_done(worker: JobThread, errors: list[Exception]) -> None:
    """A page outlives a task that raises."""
    done = threading.Event()

    def fail() -> None:
        raise ZeroDivisionError("of a task")

    worker.post(fail, "fail")
    worker.post(done.set, "next")
    assert done.wait(PATIENCE)
    assert [str(error) for error in errors] == ["of a task"]


def test_closing_ends_what_is_under_way() -> None:
    """The thread ends, and what frees the world runs in it."""
    ended = list[str]()
    worker = JobThread("worker", lambda error: None, lambda: ended.append(threading.current_thread().name))
    began = threading.Event()

    def long() -> None:
        began.set()
        while True:
            worker.check()

    worker.post(long, "long")
    assert began.wait(PATIENCE)
    worker.stop()
    assert ended == ["worker"]
    with pytest.raises(Interrupted):
        worker.check()


def test_jobs_without_a_kind_are_all_done(worker: JobThread) -> None:
    """In the order in which they came."""
    done = list[int]()
    for number in range(3):
        worker.post(lambda number=number: done.append(number))  # type: ignore[misc]
    assert worker.wait(PATIENCE)
    assert done == [0, 1, 2]
