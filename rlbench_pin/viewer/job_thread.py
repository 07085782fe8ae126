"""A thread that runs the jobs of a page in order, because only the thread that created a world can use it."""

from __future__ import annotations

import threading
from collections.abc import Callable

Job = Callable[[], None]


class Interrupted(Exception):
    """The job was cancelled."""


class JobThread:
    """Runs jobs in a separate thread, in the order in which they were added.

    Args:
        name: Name of the thread.
        on_error: Function that is called in the thread with the exception of a job; the thread then runs the next job.
        at_end: Function that is called in the thread when it ends.
    """

    def __init__(self, name: str, on_error: Callable[[Exception], None], at_end: Job = lambda: None) -> None:
        self._on_error, self._at_end = on_error, at_end
        self._jobs: dict[object, Job] = {}
        self._posted = 0
        self._changed, self._stopped, self._busy, self._interrupted = threading.Condition(), False, False, False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def post(self, job: Job, kind: str = "", *, instead: bool = False) -> None:
        """Add a job.

        Args:
            job: Function that the thread calls.
            kind: Kind of the job, which replaces a waiting job of the same kind; an empty kind replaces none.
            instead: Remove all waiting jobs, and end the current job at its next `check`.
        """
        with self._changed:
            if self._stopped:
                return
            if instead:
                self._jobs.clear()
                self._interrupted = self._busy
            self._posted += 1
            self._jobs.pop(kind, None)
            self._jobs[kind or self._posted] = job
            self._changed.notify_all()

    def check(self) -> None:
        """Raise Interrupted if the current job has to end; long jobs call this regularly."""
        if self._interrupted or self._stopped:
            raise Interrupted

    def wait(self, timeout: float) -> bool:
        """Wait up to `timeout` [s] for the end of all jobs, and return whether they have ended."""
        with self._changed:
            return self._changed.wait_for(lambda: not self._jobs and not self._busy, timeout)

    def stop(self) -> None:
        """Interrupt the current job, remove the waiting jobs, and end the thread."""
        with self._changed:
            self._stopped = True
            self._jobs.clear()
            self._changed.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(10.0)

    def _run(self) -> None:
        while (job := self._next()) is not None:
            try:
                job()
            except Interrupted:
                pass
            except Exception as error:  # an error of a task does not end the page
                self._on_error(error)
        self._at_end()

    def _next(self) -> Job | None:
        """Wait for the next job and return it; None if the thread has to end."""
        with self._changed:
            self._busy = self._interrupted = False
            self._changed.notify_all()
            self._changed.wait_for(lambda: bool(self._jobs) or self._stopped)
            if self._stopped:
                return None
            self._busy = True
            return self._jobs.pop(next(iter(self._jobs)))
