"""A thread that does one thing after the other; of several things of one kind that wait, the last counts."""

from __future__ import annotations

import threading
from collections.abc import Callable

Job = Callable[[], None]


class Worker:
    """Runs jobs in a thread of its own, in the order in which they came.

    Args:
        name: Of the thread.
        on_error: Called in that thread with what a job raised; it goes on with the next.
    """

    def __init__(self, name: str, on_error: Callable[[Exception], None]) -> None:
        self._on_error = on_error
        self._jobs: dict[object, Job] = {}
        self._numbers = 0
        self._wake, self._stopped, self._busy = threading.Condition(), False, False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def post(self, job: Job, kind: str = "") -> None:
        """Have a job done later.

        Args:
            job: What is to be done.
            kind: A job of the same kind that still waits is dropped, and this one takes a place at the end; empty keeps all.
        """
        with self._wake:
            if self._stopped:
                return
            self._numbers += 1
            self._jobs.pop(kind, None)
            self._jobs[kind or self._numbers] = job
            self._wake.notify_all()

    def wait(self, timeout: float) -> bool:
        """Wait until nothing is left to do [s]; False when there still is."""
        with self._wake:
            return self._wake.wait_for(lambda: not self._jobs and not self._busy, timeout)

    def stop(self, timeout: float = 5.0) -> None:
        """End after the present job; what waits is dropped."""
        with self._wake:
            self._stopped = True
            self._jobs.clear()
            self._wake.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout)

    def _run(self) -> None:
        while (job := self._next()) is not None:
            try:
                job()
            except Exception as error:  # whatever it is, the thread goes on
                self._on_error(error)
            with self._wake:
                self._busy = False
                self._wake.notify_all()

    def _next(self) -> Job | None:
        with self._wake:
            self._wake.wait_for(lambda: bool(self._jobs) or self._stopped)
            if self._stopped:
                return None
            self._busy = True
            return self._jobs.pop(next(iter(self._jobs)))
