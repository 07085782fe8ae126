"""Slide a baking tray into an oven that is shut."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import NO_ROTATION, DetectedSeveral, NothingGrasped, SpawnBoundary, Task


class PutTrayInOven(Task):
    """The tray must lie on the grid of the oven, right way up and so far in that the door could be shut, let go.

    The oven is shut at first and may stay open. The block on which the tray lies stands anywhere on a patch beside the door.
    """

    def init_task(self) -> None:
        """The tray may be grasped; success is all its corners in the oven, at the height of the grid, and an empty gripper."""
        self.tray, self.block = self.world.body("tray"), self.world.body("block")
        self.on_block = self.world.frame("on_block")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["tray"])
        corners = [self.world.frame(f"corner{i}") for i in range(4)]
        self.register_success_conditions([DetectedSeveral(corners, self.world.sensor("cavity"), 4), NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw the place of the block, and lay the tray on it."""
        self.patch.clear()
        self.patch.sample(self.block, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION, ignore_collisions=True)
        self.tray.set_pose(self.on_block.pose)
        return self.make_instructions()
