"""Stand a bottle on the middle shelf of a fridge that is shut."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class PutBottleInFridge(Task):
    """The bottle must stand upright on the middle shelf, behind the upper door, let go; the door may stay open."""

    def init_task(self) -> None:
        """The bottle may be grasped; success is its bottom at the shelf, its cap right above, and an empty gripper."""
        self.register_graspable_objects(["bottle"])
        on_shelf = Detected(self.world.frame("base"), self.world.sensor("inside"))
        upright = Detected(self.world.frame("cap"), self.world.sensor("cap_height"))
        self.register_success_conditions([on_shelf, upright, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return [
            "Put the bottle upright on the empty middle shelf of the fridge.",
            "The lemonade is warm, so open the refrigerator and stand the bottle on the shelf in the middle.",
            "A cold drink would be nice later: set it upright inside the fridge, on its middle level.",
        ]
