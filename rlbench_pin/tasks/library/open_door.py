"""Unlatch a door by its lever and push it open."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

ANGLE = np.deg2rad(25.0)
"""How far the lever must be turned to free the leaf, and how far the leaf must swing [rad]."""


class OpenDoor(Task):
    """The leaf must swing by 25 degrees; it is held until the lever has been turned down by 25 degrees once."""

    solved_by_chance = True

    def init_task(self) -> None:
        """Success is a swing of the leaf by 25 degrees."""
        self.leaf = self.world.joint("door/leaf_hinge")
        self.unlatched = JointMoved(self.world.joint("door/lever"), ANGLE)
        self.register_success_conditions([JointMoved(self.leaf, ANGLE)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()

    def step(self) -> None:
        """Free the leaf once the lever has been turned far enough."""
        if self.leaf.locked and self.unlatched.met():
            self.leaf.unlock()
