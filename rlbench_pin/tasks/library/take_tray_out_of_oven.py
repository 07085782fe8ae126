"""Take a baking tray out of an oven that is shut."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import DetectedSeveral, NothingGrasped, Task


class TakeTrayOutOfOven(Task):
    """The tray must come from the grid of the oven to the table, lie there right way up, and be let go."""

    def init_task(self) -> None:
        """The tray may be grasped; success is all its corners low over the table, and an empty gripper."""
        self.register_graspable_objects(["tray"])
        corners = [self.world.frame(f"corner{i}") for i in range(4)]
        on_table = DetectedSeveral(corners, self.world.sensor("over_table"), 4)
        self.register_success_conditions([on_table, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()
