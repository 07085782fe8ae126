"""Put a wine bottle into a rack."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class StackWine(Task):
    """The bottle must lie in one of the three notches of the upper row, and be released."""

    def init_task(self) -> None:
        """The bottle may be grasped; success is both ends of its belly at the height of the notches, and an empty gripper."""
        self.register_graspable_objects(["bottle"])
        notch = self.world.sensor("notch")
        ends = [Detected(self.world.frame(name), notch) for name in ("bottom", "shoulder")]
        self.register_success_conditions([*ends, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
