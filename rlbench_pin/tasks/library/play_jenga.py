"""Pull the loose brick out of a tower."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task

BRICKS = 13
"""Bricks that must stay in place."""


class PlayJenga(Task):
    """The loose brick must be completely out of the tower and be released; all other bricks must stay in place."""

    def init_task(self) -> None:
        """The loose brick may be grasped; success is that it is out while every other brick stays in place."""
        tower = self.world.sensor("tower")
        stays = [Detected(self.world.body(f"brick{i}"), tower) for i in range(BRICKS)]
        gone = Detected(self.world.body("target"), self.world.sensor("around"), negated=True)
        self.register_graspable_objects(["target"])
        self.register_success_conditions([*stays, gone, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
