"""Put a knife from a chopping board into its block."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task, clearance

APART = 0.26
"""Distance from the block to board and knife, so that neither blade nor gripper touches the block [m]."""


class PutKnifeInKnifeBlock(Task):
    """The blade must reach the bottom of the open slot of the block, and the knife must be released there.

    The places of block and board, and of the knife on the board, vary.
    """

    def init_task(self) -> None:
        """The knife may be grasped; success is its blade in the slot, and an empty gripper."""
        self.block, self.board = self.world.body("block"), self.world.body("board")
        self.base = self.world.frame("knife_base")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.on_board = SpawnBoundary([self.world.region("on_board")])
        self.register_graspable_objects(["knife"])
        inside = Detected(self.world.body("knife"), self.world.sensor("slot"))
        self.register_success_conditions([inside, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place block and board, then the knife on the board, away from the block."""
        self.patch.scatter([self.block, self.board], rng, accept=lambda: clearance(self.board, [self.block]) > APART)
        self.on_board.scatter([self.base], rng, accept=lambda: clearance(self.base, [self.block]) > APART)
        return self.make_instructions()
