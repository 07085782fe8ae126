"""One thread that does the work of a page, one piece after the other: a world belongs to the thread that made it."""

from __future__ import annotations

import threading
from collections.abc import Callable

Work = Callable[[], None]


class Interrupted(Exception):
    """What is under way is not wanted any more."""


class Worker:
    """Does what it is asked for, in turn; what is asked again while it waits is done once, the way it was asked last.

    Args:
        on_error: Called, in the thread, with what a piece of work has raised; the next one is done all the same.
        at_end: Called in the thread when it ends.
    """

    def __init__(self, on_error: Callable[[Exception], None], at_end: Work = lambda: None) -> None:
        self._on_error, self._at_end = on_error, at_end
        self._waiting: dict[str, Work] = {}
        self._changed, self._closed, self._busy = threading.Condition(), False, False
        self._interrupted = False
        self._thread = threading.Thread(target=self._run, daemon=True, name="worker")
        self._thread.start()

    def ask(self, kind: str, work: Work, *, instead: bool = False) -> None:
        """Have something done.

        Args:
            kind: What it is; what waits of the same kind is left out.
            work: Is called in the thread.
            instead: Leave out all that waits, and let what is under way end at its next `check`.
        """
        with self._changed:
            if instead:
                self._waiting.clear()
                self._interrupted = self._busy
            self._waiting.pop(kind, None)
            self._waiting[kind] = work
            self._changed.notify_all()

    def check(self) -> None:
        """Raise Interrupted when something else is wanted instead of what is under way; long work asks now and then."""
        if self._interrupted or self._closed:
            raise Interrupted

    @property
    def busy(self) -> bool:
        """Whether something is under way or waits."""
        return self._busy or bool(self._waiting)

    def wait(self, timeout: float) -> bool:
        """Wait until all is done, at most `timeout` [s], and say whether it is."""
        with self._changed:
            return self._changed.wait_for(lambda: not self.busy, timeout)

    def close(self) -> None:
        """Interrupt what is under way, leave out what waits, and end the thread."""
        with self._changed:
            self._closed = True
            self._waiting.clear()
            self._changed.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=10.0)

    def _run(self) -> None:
        while (work := self._next()) is not None:
            try:
                work()
            except Interrupted:
                pass
            except Exception as error:  # a page outlives what goes wrong in a task
                self._on_error(error)
        self._at_end()

    def _next(self) -> Work | None:
        with self._changed:
            self._busy, self._interrupted = False, False
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._closed or bool(self._waiting))
            if self._closed:
                return None
            work = self._waiting.pop(next(iter(self._waiting)))
            self._busy = True
            return work
