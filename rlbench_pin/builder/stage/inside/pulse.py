"""Signs of life of work that takes long and shows nothing."""

from __future__ import annotations

import time
from collections.abc import Callable

from rlbench_pin.environment.runtime import Listener
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.listener import PlanRequest
from rlbench_pin.planning.plan import Plan

INTERVAL = 0.5
"""Least time between two signs [s]."""


class Pulse(Listener):
    """Calls back while a runtime plans, simulates or looks for configurations, not too often.

    Args:
        on_alive: Called without arguments; what it raises ends the work.
        interval: Least time between two calls [s].
    """

    def __init__(self, on_alive: Callable[[], None], interval: float = INTERVAL) -> None:
        self._on_alive, self._interval, self._last = on_alive, interval, time.monotonic()

    def on_reach(self, seconds: float) -> None:
        """A configuration was looked for."""
        self._beat()

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """A motion was planned."""
        self._beat()

    def on_tick(self, seconds: float) -> None:
        """A control tick was simulated."""
        self._beat()

    def _beat(self) -> None:
        if time.monotonic() - self._last >= self._interval:
            self._last = time.monotonic()
            self._on_alive()
