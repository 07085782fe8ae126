"""Turn the long hand of a clock with the key on its back."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class ChangeClock(Task):
    """The long hand must point to three (a quarter past twelve)."""

    def init_task(self) -> None:
        """Success is that the long hand covers the mark of three o'clock."""
        self.register_success_conditions([Detected(self.world.body("clock"), self.world.sensor("quarter"))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
