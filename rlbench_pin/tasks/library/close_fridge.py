"""Shut the upper door of a fridge."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class CloseFridge(Task):
    """The upper door is open by 97 degrees and must swing by 76 degrees; at success it may still be up to 22 degrees open."""

    solved_by_chance = True  # a random push can shut the door

    def init_task(self) -> None:
        """Success is a rotation of the upper door by more than 1.32 rad, which is only possible inwards."""
        self.register_success_conditions([JointMoved(self.world.joint("fridge/upper_door"), 1.32)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
