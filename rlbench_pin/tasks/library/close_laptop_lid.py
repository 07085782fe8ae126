"""Shut the screen of a notebook computer."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class CloseLaptopLid(Task):
    """The screen starts leaning back; it must turn by 1.79 rad, nearly onto the keyboard."""

    def init_task(self) -> None:
        """Success is a turn of the screen by more than 1.79 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("laptop/screen_hinge"), 1.79)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return [
            "Close the laptop.",
            "The notebook computer is open: fold its screen down onto the keyboard.",
            "Work is over, so please bring the lid of the portable computer all the way down.",
        ]
