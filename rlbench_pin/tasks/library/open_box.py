"""Open the lid of a carton."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenBox(Task):
    """The lid must rotate by more than 90 degrees, past its upright position."""

    def init_task(self) -> None:
        """Success is a rotation of the lid by more than 90 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("carton/lid_hinge"), np.pi / 2.0)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
