"""Put seven groceries into a cupboard."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import DetectedSeveral, NothingGrasped, SpawnBoundary, Task, Waypoint

ITEMS = ("crackers", "sugar", "mustard", "spam", "soup", "chocolate_jello", "strawberry_jello")
"""In the order of the demonstration: tall ones first, so that they are not in the way of the others."""
APART = 0.15
"""Distance of the items from each other on the table [m]."""


class PutAllGroceriesInCupboard(Task):
    """All seven items must be on the shelves, let go; which shelf and which way up does not matter."""

    def init_task(self) -> None:
        """All items may be grasped; success is all of them on the shelves, let go. Each round aims at the next item."""
        self.items = [self.world.body(name) for name in ITEMS]
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(ITEMS)
        self.register_waypoint_ability_start(0, self._aim_at_next_item)
        stowed = DetectedSeveral(self.items, self.world.sensor("shelves"), len(ITEMS))
        self.register_success_conditions([stowed, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Scatter the items."""
        self.register_rounds(len(ITEMS))
        self.patch.scatter(self.items, rng, min_distance=APART)
        return self.make_instructions()

    def _aim_at_next_item(self, waypoint: Waypoint) -> None:
        """Go for the next item, and for its place on the shelves."""
        item = ITEMS[self.round]
        self.world.frame("waypoint1").set_parent(f"grasp_{item}")
        self.world.frame("waypoint4").set_parent(f"stow_{item}")
