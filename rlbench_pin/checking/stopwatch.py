"""Where the time of a demonstration goes: planning, physics, looking, and the rest."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rlbench_pin.environment.runtime import Runtime


class Stopwatch:
    """Adds up process time [s] by kind of work, while `watching` a scene.

    Attributes:
        spent: Kind of work -> process time [s], what it calls of another kind not counted twice.
        total: Process time between entering and leaving `watching` [s].
        ticks: Control ticks simulated.
    """

    def __init__(self) -> None:
        self.spent = {"planning": 0.0, "physics": 0.0, "observing": 0.0}
        self.total = 0.0
        self.ticks = 0
        self._busy = False

    @contextmanager
    def watching(self, runtime: Runtime) -> Iterator[None]:
        """Measure everything that `runtime` does in the block."""
        planner = runtime.planner
        watched = [
            *((planner, name, "planning") for name in ("plan_to_pose", "plan_curve", "reachable", "update")),
            (runtime.world, "step", "physics"),
            (runtime.observer, "observe", "observing"),
        ]
        for thing, name, kind in watched:
            setattr(thing, name, self._timed(getattr(thing, name), kind))
        began = time.process_time()
        try:
            yield
        finally:
            self.total += time.process_time() - began
            for thing, name, _ in watched:
                delattr(thing, name)

    def _timed(self, call: Callable[..., Any], kind: str) -> Callable[..., Any]:
        def timed(*args: Any, **options: Any) -> Any:
            if self._busy:
                return call(*args, **options)
            self._busy, began = True, time.process_time()
            try:
                return call(*args, **options)
            finally:
                self._busy = False
                self.spent[kind] += time.process_time() - began
                self.ticks += kind == "physics"

        return timed
