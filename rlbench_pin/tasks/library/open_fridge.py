"""Pull open the upper door of a fridge."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenFridge(Task):
    """Both doors are shut at the start; the upper door must swing by 70 degrees."""

    def init_task(self) -> None:
        """Success is a rotation of the upper door by 70 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("fridge/upper_door"), np.deg2rad(70.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
