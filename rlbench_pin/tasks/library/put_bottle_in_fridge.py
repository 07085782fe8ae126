"""Open a fridge and put a bottle on its middle shelf."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class PutBottleInFridge(Task):
    """The bottle must be upright on the middle shelf, behind the upper door, and be released; the door may stay open."""

    def init_task(self) -> None:
        """The bottle may be grasped; success is its bottom at the shelf, its cap straight above it, and an empty gripper."""
        self.register_graspable_objects(["bottle"])
        on_shelf = Detected(self.world.frame("base"), self.world.sensor("inside"))
        upright = Detected(self.world.frame("cap"), self.world.sensor("cap_height"))
        self.register_success_conditions([on_shelf, upright, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
