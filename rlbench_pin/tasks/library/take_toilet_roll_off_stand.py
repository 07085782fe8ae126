"""Take a roll of toilet paper off the arm of a stand."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Grasped, InOrder, Task


class TakeToiletRollOffStand(Task):
    """The roll must be off the arm, after the gripper has held it. A roll that was knocked off does not count."""

    def init_task(self) -> None:
        """The roll may be grasped; success is that the gripper has held it, and it is off the arm."""
        roll = self.world.body("roll")
        self.register_graspable_objects(["roll"])
        off = Detected(roll, self.world.sensor("arm_zone"), negated=True)
        self.register_success_conditions([InOrder([Grasped(self.gripper, roll)]), off])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
