"""Pull the loose brick out of a tower."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task

BRICKS = 13
"""Bricks that must stay."""


class PlayJenga(Task):
    """The brick that sticks out must come right out of the tower and be let go; all others must stay."""

    def init_task(self) -> None:
        """The loose brick may be grasped; success is that it is out while every other brick stays."""
        tower = self.world.sensor("tower")
        stays = [Detected(self.world.body(f"brick{i}"), tower) for i in range(BRICKS)]
        gone = Detected(self.world.body("target"), self.world.sensor("around"), negated=True)
        self.register_graspable_objects(["target"])
        self.register_success_conditions([*stays, gone, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()
