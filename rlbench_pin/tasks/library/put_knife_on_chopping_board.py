"""Pull a knife out of its block and lay it on a chopping board."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task


class PutKnifeOnChoppingBoard(Task):
    """The handle and the blade of the knife must be on the chopping board, and the knife be released. It starts in its block.

    The place of the block varies.
    """

    def init_task(self) -> None:
        """The knife may be grasped; success is the knife on the board, and an empty gripper."""
        self.block = self.world.body("block")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["knife"])
        lies = [Detected(self.world.frame(part), self.world.sensor("on_board")) for part in ("handle", "blade")]
        self.register_success_conditions([*lies, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the block with the knife."""
        self.patch.scatter([self.block], rng)
        return self.make_instructions()
