"""Lift a cube with a spatula."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Grasped, Task


class ScoopWithSpatula(Task):
    """The cube must be in the air while the gripper holds the spatula."""

    def init_task(self) -> None:
        """The spatula may be grasped; success is the cube in the air while the gripper holds the spatula."""
        spatula, cube = self.world.body("spatula"), self.world.body("cube")
        self.register_graspable_objects(["spatula"])
        self.register_success_conditions([Detected(cube, self.world.sensor("air")), Grasped(self.gripper, spatula)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
