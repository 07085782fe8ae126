"""Lift one of three numbered blocks."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Grasped, SpawnBoundary, Task


class LiftNumberedBlock(Task):
    """The gripper must hold the block with the requested number above the table. The three blocks start at random places."""

    numbers = (1, 2, 3)

    def init_task(self) -> None:
        """All blocks may be grasped."""
        self.blocks = [self.world.body(f"block{number}") for number in self.numbers]
        self.height = self.world.sensor("height")
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(block.name for block in self.blocks)

    def variation_count(self) -> int:
        """One for each number."""
        return len(self.numbers)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the blocks at random; success is that the gripper holds the requested block in the air."""
        number, block = self.numbers[variation], self.blocks[variation]
        self.boundary.scatter(self.blocks, rng, min_distance=0.2)
        self.world.frame("waypoint1").set_parent(block.name)
        self.register_success_conditions([Grasped(self.gripper, block), Detected(block, self.height)])
        return self.make_instructions(number=number, word=("one", "two", "three")[variation])
