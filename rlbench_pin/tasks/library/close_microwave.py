"""Shut the door of a microwave."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class CloseMicrowave(Task):
    """The door is wide open and must swing by 40 degrees; at success it may still be up to 29 degrees open."""

    def init_task(self) -> None:
        """Success is a rotation of the door by 40 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("microwave/door"), np.deg2rad(40.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
