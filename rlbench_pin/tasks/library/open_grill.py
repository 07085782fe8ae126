"""Raise the hood of a barbecue."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenGrill(Task):
    """The hood is shut and must turn up by 50 degrees."""

    def init_task(self) -> None:
        """Success is a turn of the hood by 50 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("grill/lid"), np.deg2rad(50.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()
