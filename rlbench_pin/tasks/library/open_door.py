"""Unlatch a door by its lever and push it open."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

ANGLE = np.deg2rad(25.0)
"""Angle of the lever that unlatches the door, and angle by which the door must swing [rad]."""


class OpenDoor(Task):
    """The door must swing by 25 degrees; it is latched until the lever has been turned down by 25 degrees."""

    solved_by_chance = True

    def init_task(self) -> None:
        """Success is a swing of the door by 25 degrees."""
        self.leaf = self.world.joint("door/leaf_hinge")
        self.unlatched = JointMoved(self.world.joint("door/lever"), ANGLE)
        self.register_success_conditions([JointMoved(self.leaf, ANGLE)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()

    def step(self) -> None:
        """Unlatch the door when the lever has been turned far enough."""
        if self.leaf.locked and self.unlatched.met():
            self.leaf.unlock()
