"""Flip a rocker switch on a wall."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class PressSwitch(Task):
    """The rocker must tip over to its other end, by more than 1 rad of the 1.2 rad that it turns."""

    def init_task(self) -> None:
        """Success is a turn of the rocker by 1 rad."""
        self.register_success_conditions([JointMoved(self.world.joint("panel/rocker_joint"), 1.0)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return [
            "Flip the switch on the wall.",
            "The upper half of the rocker stands out, so press it in.",
            "It should be light in here: tip the wall switch over to its other end.",
        ]
