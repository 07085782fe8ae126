"""Pull a knife out of its block and lay it on a chopping board."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task


class PutKnifeOnChoppingBoard(Task):
    """The knife, in its block at first, must be on the chopping board, let go.

    The place of the block varies.
    """

    def init_task(self) -> None:
        """The knife may be grasped; success is the knife on the board, and an empty gripper."""
        self.block = self.world.body("block")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["knife"])
        on_board = Detected(self.world.body("knife"), self.world.sensor("on_board"))
        self.register_success_conditions([on_board, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the block with the knife."""
        self.patch.scatter([self.block], rng)
        return [
            "Draw the knife from its block and lay it on the board.",
            "I am about to chop, so get the knife onto the board.",
            "Bring the knife from its block to the chopping board.",
        ]
