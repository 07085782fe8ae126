"""Pull a memory stick out of the port of a computer."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class TakeUsbOutOfComputer(Task):
    """The stick must be out of the port in the front of the computer, and be released."""

    def init_task(self) -> None:
        """The stick may be grasped; success is that it is out of the port, and an empty gripper."""
        self.register_graspable_objects(["stick"])
        out = Detected(self.world.body("stick"), self.world.sensor("port"), negated=True)
        self.register_success_conditions([out, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
