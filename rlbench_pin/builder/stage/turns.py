"""Threads take turns at a process: one operation at a time, and nobody waits for ever."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rlbench_pin.builder.stage.faults import StageBusy


class Turns:
    """Lets one operation run at a time.

    Args:
        wait: How long an operation waits for the one before it [s].
    """

    def __init__(self, wait: float) -> None:
        self._wait, self._lock = wait, threading.Lock()
        self._running, self._thread = "", 0

    @property
    def running(self) -> str:
        """Name of the operation that runs, empty when none does."""
        return self._running

    @contextmanager
    def take(self, operation: str) -> Iterator[None]:
        """Run a block as an operation.

        Raises:
            StageBusy: Another one did not end in time, or the operation was asked for by a callback of the one that runs.
        """
        mine = threading.get_ident()
        if self._thread == mine or not self._lock.acquire(timeout=self._wait):
            raise StageBusy(operation, self._running)
        self._running, self._thread = operation, mine
        try:
            yield
        finally:
            self._running, self._thread = "", 0
            self._lock.release()
