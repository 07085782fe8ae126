"""Sweep crumbs into a dustpan with a broom."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task

CRUMBS = 5


class SweepToDustpan(Task):
    """All five crumbs must be in the dustpan."""

    def init_task(self) -> None:
        """The broom may be grasped; success is every crumb in the pan."""
        self.register_graspable_objects(["broom"])
        pan = self.world.sensor("pan")
        self.register_success_conditions([Detected(self.world.body(f"crumb{i}"), pan) for i in range(CRUMBS)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
