"""Shut the screen of a notebook computer."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class CloseLaptopLid(Task):
    """The screen leans back at the start and must rotate by 1.79 rad; at success it may still be up to 6 degrees open."""

    def init_task(self) -> None:
        """Success is a rotation of the screen by more than 1.79 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("laptop/screen_hinge"), 1.79)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
