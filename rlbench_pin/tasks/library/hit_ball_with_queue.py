"""Strike a ball into a pocket with a cue."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Grasped, InOrder, Task


class HitBallWithQueue(Task):
    """The ball must be in the pocket after the gripper has held the cue."""

    def init_task(self) -> None:
        """The cue may be grasped; success is a grasp of the cue, then the ball in the pocket."""
        cue, ball = self.world.body("cue"), self.world.body("ball")
        self.register_graspable_objects(["cue"])
        in_pocket = Detected(ball, self.world.sensor("pocket"))
        self.register_success_conditions([InOrder([Grasped(self.gripper, cue), in_pocket])])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
