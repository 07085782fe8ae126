"""Push a block along the table onto a square."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class SlideBlockToTarget(Task):
    """The red block must reach the middle of the green square. It cannot be grasped."""

    def init_task(self) -> None:
        """Success is the block on the middle of the square."""
        self.block = self.world.body("block")
        self.square = self.world.body("square")
        self.register_success_conditions([Detected(self.block, self.world.sensor("target"))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()

    def reward(self) -> float:
        """Return minus the distances from tip to block and from block to square [m]."""
        to_block = np.linalg.norm(self.robot.tip_pose()[:3] - self.block.position)
        to_target = np.linalg.norm(self.block.position - self.square.position)
        return -float(to_block) - float(to_target)

    def get_low_dim_state(self) -> np.ndarray:
        """Return the positions of block and square, shape (6,) [m]."""
        return np.concatenate([self.block.position, self.square.position])
