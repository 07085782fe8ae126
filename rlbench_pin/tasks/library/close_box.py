"""Fold the lid of an open carton over onto it."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class CloseBox(Task):
    """The lid hangs outwards at the start and must turn by 2.6 rad; at success it may still be up to 11 degrees open."""

    def init_task(self) -> None:
        """Success is a rotation of the lid by more than 2.6 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("carton/lid_hinge"), 2.6)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
