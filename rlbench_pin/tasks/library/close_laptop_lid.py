"""Shut the screen of a notebook computer."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class CloseLaptopLid(Task):
    """The screen starts leaning back; it must turn by 1.79 rad; success leaves it up to 6 degrees open."""

    def init_task(self) -> None:
        """Success is a turn of the screen by more than 1.79 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("laptop/screen_hinge"), 1.79)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()
