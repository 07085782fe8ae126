"""Put a bundle of banknotes into a safe."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task


class PutMoneyInSafe(Task):
    """The bundle must be on the requested one of three levels of the open safe, and be released.

    The requested level and the place of the bundle on the table vary.
    """

    levels = ("bottom", "middle", "top")

    def init_task(self) -> None:
        """The bundle may be grasped."""
        self.money = self.world.body("money")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["money"])

    def variation_count(self) -> int:
        """One for each level."""
        return len(self.levels)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the bundle, and aim at the requested level; success is the bundle on this level, and an empty gripper."""
        level = self.levels[variation]
        self.patch.clear()
        self.patch.sample(self.money, rng, min_rotation=(0.0, 0.0, 0.0), max_rotation=(0.0, 0.0, np.pi / 2.0))
        self.world.frame("waypoint4").move_to(f"stow_{level}")
        self.register_success_conditions([NothingGrasped(self.gripper), Detected(self.money, self.world.sensor(f"in_{level}"))])
        return self.make_instructions(level=level)
