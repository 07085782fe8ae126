"""Raise the hood of a barbecue."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenGrill(Task):
    """The hood is shut at the start and must rotate up by 50 degrees."""

    def init_task(self) -> None:
        """Success is a rotation of the hood by 50 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("grill/lid"), np.deg2rad(50.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
