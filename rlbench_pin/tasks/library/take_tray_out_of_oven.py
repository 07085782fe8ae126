"""Open an oven and take a baking tray out."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import DetectedSeveral, NothingGrasped, Task


class TakeTrayOutOfOven(Task):
    """The tray must be on the table, right side up, and be released. It starts on the grid of the shut oven."""

    def init_task(self) -> None:
        """The tray may be grasped; success is all its corners near the table, and an empty gripper."""
        self.register_graspable_objects(["tray"])
        corners = [self.world.frame(f"corner{i}") for i in range(4)]
        on_table = DetectedSeveral(corners, self.world.sensor("over_table"), 4)
        self.register_success_conditions([on_table, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
