"""Fold down the seat of a toilet."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class ToiletSeatDown(Task):
    """The seat starts upright, leaning back a little; it must turn by 1.7 rad; success leaves it up to 6 degrees raised."""

    def init_task(self) -> None:
        """Success is a turn of the seat by more than 1.7 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("toilet/seat_hinge"), 1.7)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()
