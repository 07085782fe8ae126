"""Open an oven and slide a baking tray into it."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import NO_ROTATION, DetectedSeveral, NothingGrasped, SpawnBoundary, Task


class PutTrayInOven(Task):
    """The tray must be on the grid of the oven, right side up, so deep inside that the door can shut, and be released.

    The oven is shut at the start and may stay open. The tray starts on a block at a random place beside the door.
    """

    def init_task(self) -> None:
        """The tray may be grasped; success is all its corners in the oven at the height of the grid, and an empty gripper."""
        self.tray, self.block = self.world.body("tray"), self.world.body("block")
        self.on_block = self.world.frame("on_block")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["tray"])
        corners = [self.world.frame(f"corner{i}") for i in range(4)]
        self.register_success_conditions([DetectedSeveral(corners, self.world.sensor("cavity"), 4), NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw the place of the block, and put the tray on it."""
        self.patch.clear()
        self.patch.sample(self.block, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION, ignore_collisions=True)
        self.tray.set_pose(self.on_block.pose)
        return self.make_instructions()
