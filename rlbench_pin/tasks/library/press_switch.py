"""Flip a rocker switch on a wall."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

SHINING, DARK = (1.0, 0.85, 0.2), (0.3, 0.28, 0.24)


class PressSwitch(Task):
    """The rocker must tip to its other end, by more than 1 rad of its range of 1.2 rad.

    Lamps on both sides of the wall are on while the rocker is past its middle.
    """

    def init_task(self) -> None:
        """Success is a rotation of the rocker by 1 rad."""
        self.rocker = self.world.joint("panel/rocker_joint")
        self.register_success_conditions([JointMoved(self.rocker, 1.0)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Switch the lamps off; only the placement of the task varies."""
        self.step()
        return self.make_instructions()

    def step(self) -> None:
        """Switch the lamps on or off with the rocker."""
        self.world.body("panel").set_color(SHINING if self.rocker.position > 0.0 else DARK, "lamp")
