"""Unlatch a door by its lever and push it open."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

ANGLE = np.deg2rad(25.0)
"""How far the lever must be turned to free the leaf, and how far the leaf must swing [rad]."""


class OpenDoor(Task):
    """The leaf must swing by 25 degrees; it is held until the lever has been turned down by 25 degrees once."""

    def init_task(self) -> None:
        self.leaf = self.world.joint("door/leaf_hinge")
        self.unlatched = JointMoved(self.world.joint("door/lever"), ANGLE)
        self.register_success_conditions([JointMoved(self.leaf, ANGLE)])

    def variation_count(self) -> int:
        return 1

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        return [
            "Turn the lever and push the door.",
            "Unlatch the door, then swing it open.",
            "Press the door handle down and go through the door.",
        ]

    def step(self) -> None:
        if self.leaf.locked and self.unlatched.met():
            self.leaf.unlock()
