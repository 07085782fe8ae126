"""Lay a wine bottle into a rack."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class StackWine(Task):
    """The bottle must lie in one of the three notches of the upper row, let go."""

    def init_task(self) -> None:
        """The bottle may be grasped; success is both ends of its belly at the height of the notches, and an empty gripper."""
        self.register_graspable_objects(["bottle"])
        notch = self.world.sensor("notch")
        ends = [Detected(self.world.frame(name), notch) for name in ("bottom", "shoulder")]
        self.register_success_conditions([*ends, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return [
            "Lay the bottle of wine in the upper row of the rack.",
            "The wine should be stored lying down, so put the bottle into a notch at the top of the wooden holder.",
            "A bottle was left beside the rack: move it to the free row above the others.",
        ]
