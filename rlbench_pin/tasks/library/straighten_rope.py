"""Pull a rope straight."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class StraightenRope(Task):
    """Both ends of the rope must be on their marks. The distance between the marks is nearly the length of the rope."""

    def init_task(self) -> None:
        """Success is each end of the rope on its mark."""
        head = Detected(self.world.frame("head"), self.world.sensor("at_head_mark"))
        tail = Detected(self.world.frame("tail"), self.world.sensor("at_tail_mark"))
        self.register_success_conditions([head, tail])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
