"""Pull a door shut by its lever."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class CloseDoor(Task):
    """The door is open, away from the arm, and must swing back by 25 degrees; at success it may still be up to 9 degrees open."""

    def init_task(self) -> None:
        """Success is a swing of the leaf by 25 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("door/leaf_hinge"), np.deg2rad(25.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
