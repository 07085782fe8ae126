"""Open the round door of a washing machine."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenWashingMachine(Task):
    """The round door is shut at the start and must swing by 40 degrees."""

    def init_task(self) -> None:
        """Success is a rotation of the door by 40 degrees."""
        self.register_success_conditions([JointMoved(self.world.joint("washing_machine/door"), np.deg2rad(40.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
