"""Put seven groceries into a cupboard."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import DetectedSeveral, NothingGrasped, SpawnBoundary, Task, Waypoint

ITEMS = ("crackers", "sugar", "mustard", "spam", "soup", "chocolate_jello", "strawberry_jello")
"""In the order of the demonstration: tall items first, so that they do not obstruct the grasps of the others."""
APART = 0.15
"""Distance of the items from each other on the table [m]."""


class PutAllGroceriesInCupboard(Task):
    """All seven items must be on the shelves, on any shelf and in any orientation, and be released."""

    def init_task(self) -> None:
        """All items may be grasped; each round aims at the next one. Success is all on the shelves, and an empty gripper."""
        self.items = [self.world.body(name) for name in ITEMS]
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(ITEMS)
        self.register_waypoint_ability_start(0, self._aim_at_next_item)
        stowed = DetectedSeveral(self.items, self.world.sensor("shelves"), len(ITEMS))
        self.register_success_conditions([stowed, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the items at random."""
        self.register_rounds(len(ITEMS))
        self.patch.scatter(self.items, rng, min_distance=APART)
        return self.make_instructions()

    def _aim_at_next_item(self, waypoint: Waypoint) -> None:
        """Aim at the next item, and at its place on the shelves."""
        item = ITEMS[self.round]
        self.world.frame("waypoint1").set_parent(f"grasp_{item}")
        self.world.frame("waypoint4").set_parent(f"stow_{item}")
