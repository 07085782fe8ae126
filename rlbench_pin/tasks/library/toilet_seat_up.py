"""Fold up the seat of a toilet."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class ToiletSeatUp(Task):
    """The seat lies on the bowl and must turn by 1.4 rad, nearly upright."""

    def init_task(self) -> None:
        """Success is a turn of the seat by more than 1.4 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("toilet/seat_hinge"), 1.4)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()
