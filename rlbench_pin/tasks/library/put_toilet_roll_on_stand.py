"""Put a roll of toilet paper on the arm of a stand."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task


class PutToiletRollOnStand(Task):
    """The roll must be on the arm, at the post, and be released. The places and yaws of the roll's block and of the stand vary.

    The roll is on the arm if both ends of its hole are around the arm.
    """

    def init_task(self) -> None:
        """The roll may be grasped; success is the roll on the arm, at the post, and an empty gripper."""
        self.block, self.stand = self.world.body("block"), self.world.body("stand")
        self.patches = [SpawnBoundary([self.world.region(name)]) for name in ("block_patch", "stand_patch")]
        at_post = Detected(self.world.body("roll"), self.world.sensor("arm_root"))
        ends = [Detected(self.world.frame(f"end{i}"), self.world.sensor("around_arm")) for i in range(2)]
        self.register_graspable_objects(["roll"])
        self.register_success_conditions([at_post, *ends, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the block with the roll, and the stand."""
        for patch, body in zip(self.patches, (self.block, self.stand), strict=True):
            patch.scatter([body], rng)
        return self.make_instructions()
