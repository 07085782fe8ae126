"""Open a shoe box and put a pair of shoes into it."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import DetectedSeveral, NothingGrasped, Task


class PutShoesInBox(Task):
    """Both shoes must be in the box, with heels and toes below its rim, and be released; the lid may stay open."""

    def init_task(self) -> None:
        """Both shoes may be grasped; success is both heels and both toes inside the box, and an empty gripper."""
        self.register_graspable_objects(["shoe_left", "shoe_right"])
        ends = [self.world.frame(name) for name in ("heel_left", "toe_left", "heel_right", "toe_right")]
        self.register_success_conditions(
            [DetectedSeveral(ends, self.world.sensor("box_inside"), 4), NothingGrasped(self.gripper)]
        )

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
