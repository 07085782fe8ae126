"""Take one of three bundles of banknotes out of a safe."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task

TURN = 0.262
"""Largest yaw of the bundle on the table, to either side [rad]."""


class TakeMoneyOutSafe(Task):
    """The bundle from the requested one of three levels must be on the table in front of the open safe, and be released.

    The requested level and the places of the bundles on their levels vary.
    """

    levels = ("bottom", "middle", "top")

    def init_task(self) -> None:
        """All bundles may be grasped."""
        self.bundles = [self.world.body(f"money_{level}") for level in self.levels]
        self.inside = SpawnBoundary([self.world.region("inside")])
        self.table = SpawnBoundary([self.world.region("place")])
        self.register_graspable_objects(bundle.name for bundle in self.bundles)

    def variation_count(self) -> int:
        """One for each level."""
        return len(self.levels)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the bundles, and aim at the requested one; success is this bundle on the table, and an empty gripper."""
        level, bundle = self.levels[variation], self.bundles[variation]
        self.inside.clear()
        for other in self.bundles:
            self.inside.sample(other, rng, min_rotation=(0.0, 0.0, -0.314), max_rotation=(0.0, 0.0, 0.0), min_distance=0.0)
        self.table.clear()
        self.table.sample(
            self.world.frame("waypoint3"), rng, min_rotation=(0.0, 0.0, -TURN), max_rotation=(0.0, 0.0, TURN), min_distance=0.0
        )
        self.world.frame("waypoint1").set_parent(bundle.name)
        self.register_success_conditions([NothingGrasped(self.gripper), Detected(bundle, self.world.sensor("on_table"))])
        return self.make_instructions(level=level)
