"""Open a shoe box and take a pair of shoes out."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, DetectedSeveral, NothingGrasped, Task


class TakeShoesOutOfBox(Task):
    """Both shoes must be on the table outside the box, either side up, and be released; the lid may stay open."""

    def init_task(self) -> None:
        """Both shoes may be grasped; success is both heels and toes near the table, outside the box, and an empty gripper."""
        shoes = ("shoe_left", "shoe_right")
        self.register_graspable_objects(shoes)
        ends = [self.world.frame(name) for name in ("heel_left", "toe_left", "heel_right", "toe_right")]
        on_table = DetectedSeveral(ends, self.world.sensor("outside"), 4)
        unpacked = [Detected(self.world.body(shoe), self.world.sensor("box_inside"), negated=True) for shoe in shoes]
        self.register_success_conditions([on_table, *unpacked, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
