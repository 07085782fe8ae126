"""Where the time of a plan goes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from rlbench_pin.planning.plan import Plan


@dataclass(eq=False)
class Stages:
    """Measures how long each stage takes."""

    seconds: dict[str, float] = field(default_factory=dict)
    """Stage -> time spent in it [s]."""
    checks: int = 0
    """Collision checks that the model had counted before."""
    plan: Plan | None = None
    """What came of it; None while planning, and when it fails."""

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time until the block ends to stage `name`."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin
