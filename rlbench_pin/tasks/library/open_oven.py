"""Open the door of an oven."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class OpenOven(Task):
    """The door must be flat in front of the oven, and the gripper must hold nothing."""

    def init_task(self) -> None:
        """Success is the door flat in front of the oven, and an empty gripper."""
        door_is_down = Detected(self.world.body("oven"), self.world.sensor("door_down"))
        self.register_success_conditions([door_is_down, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
