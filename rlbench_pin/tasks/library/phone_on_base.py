"""Put a cordless handset into its charging cradle."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class PhoneOnBase(Task):
    """The contacts of the handset must be at the lower end of the recess of the cradle, and the handset be released."""

    def init_task(self) -> None:
        """The handset may be grasped; success is its contacts in the cradle, and an empty gripper."""
        self.register_graspable_objects(["handset"])
        docked = Detected(self.world.frame("contacts"), self.world.sensor("cradle"))
        self.register_success_conditions([docked, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
