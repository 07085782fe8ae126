"""Where the time of a demonstration goes: planning, physics, observing, and the rest."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rlbench_pin.environment.runtime import Listener, Runtime
from rlbench_pin.errors import PlanningError
from rlbench_pin.planning.listener import PlanRequest
from rlbench_pin.planning.plan import Plan
from rlbench_pin.scene.snapshot import WorldSnapshot


class Stopwatch(Listener):
    """Adds up process time [s] by kind of work, while `watching` a runtime.

    Attributes:
        spent: Kind of work (`planning`, `physics`, `observing`) -> process time [s].
        total: Process time between entering and leaving `watching` [s].
        ticks: Control ticks simulated.
    """

    def __init__(self) -> None:
        self.spent = {"planning": 0.0, "physics": 0.0, "observing": 0.0}
        self.total = 0.0
        self.ticks = 0

    @contextmanager
    def watching(self, runtime: Runtime) -> Iterator[None]:
        """Measure everything that `runtime` does in the block."""
        with runtime.listening(self):
            began = time.process_time()
            try:
                yield
            finally:
                self.total += time.process_time() - began

    def on_update(self, snapshot: WorldSnapshot, seconds: float) -> None:
        """Count as planning."""
        self.spent["planning"] += seconds

    def on_plan(self, request: PlanRequest, outcome: Plan | PlanningError, seconds: float) -> None:
        """Count as planning, found or not."""
        self.spent["planning"] += seconds

    def on_reach(self, seconds: float) -> None:
        """Count as planning."""
        self.spent["planning"] += seconds

    def on_tick(self, seconds: float) -> None:
        """Count as physics."""
        self.spent["physics"] += seconds
        self.ticks += 1

    def on_observe(self, seconds: float) -> None:
        """Count as observing."""
        self.spent["observing"] += seconds
