"""Set the table for one person: a plate, a fork, a knife, a spoon and a glass."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task

PIECES = ("plate", "fork", "knife", "spoon", "glass")
POINTS = (
    *("plate_middle", "fork_middle", "fork_tip", "knife_middle", "knife_tip"),
    *("spoon_middle", "spoon_tip", "glass_middle", "glass_rim"),
)
"""Points of the pieces; each must be in the sensor `<point>_place`."""


class SetTheTable(Task):
    """The plate must be in the middle, the fork at its left, knife and spoon at its right, and the glass behind it.

    All pieces must be released.
    """

    def init_task(self) -> None:
        """All pieces may be grasped; success is every point at its place and an empty gripper."""
        self.register_graspable_objects(PIECES)
        placed = [Detected(self.world.frame(point), self.world.sensor(f"{point}_place")) for point in POINTS]
        self.register_success_conditions([*placed, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
