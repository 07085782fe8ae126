"""Open the screen of a notebook computer."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenLaptopLid(Task):
    """The screen is open by 20 degrees at the start; it must rotate by 70 degrees, until it is upright."""

    def init_task(self) -> None:
        """Success is a rotation of the screen by more than 70 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("laptop/screen_hinge"), np.deg2rad(70.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
