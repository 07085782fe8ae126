"""Lift the seat of a toilet."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class ToiletSeatUp(Task):
    """The seat is on the bowl at the start and must rotate by 1.4 rad, until it is nearly upright."""

    def init_task(self) -> None:
        """Success is a rotation of the seat by more than 1.4 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("toilet/seat_hinge"), 1.4)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
