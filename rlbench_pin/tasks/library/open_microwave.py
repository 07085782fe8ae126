"""Pull open the door of a microwave."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenMicrowave(Task):
    """The door is shut at the start and must swing by 80 degrees."""

    def init_task(self) -> None:
        """Success is a swing of the door by 80 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("microwave/door"), np.deg2rad(80.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
