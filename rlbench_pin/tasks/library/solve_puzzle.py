"""Put the last piece into a jigsaw puzzle."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class SolvePuzzle(Task):
    """The loose piece must be in the gap, in the right orientation, and be released."""

    def init_task(self) -> None:
        """The piece may be grasped; success is the piece at the bottom of the gap, its image upright, and an empty gripper."""
        self.register_graspable_objects(["piece"])
        in_gap = Detected(self.world.body("piece"), self.world.sensor("gap"))
        upright = Detected(self.world.frame("upper_edge"), self.world.sensor("upper_side"))
        self.register_success_conditions([in_gap, upright, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
