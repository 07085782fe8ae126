"""Put one grocery item on the lower shelf of a cupboard."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task

FREE = 0.15
"""Distance of the asked item from the others [m]."""
ATTEMPTS = 50


class PutGroceriesInCupboard(Task):
    """The asked one of nine items must be on the lower shelf, let go; which way up does not matter.

    Which item is asked for varies, and where the nine stand on the table.
    """

    items = ("crackers", "chocolate_jello", "strawberry_jello", "soup", "tuna", "spam", "coffee", "mustard", "sugar")

    def init_task(self) -> None:
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(self.items)

    def variation_count(self) -> int:
        return len(self.items)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        item = self.items[variation]
        self._scatter(item, rng)
        self.world.frame("waypoint1").set_parent(f"grasp_{item}")
        self.world.frame("waypoint4").set_parent(f"stow_{item}")
        stowed = Detected(self.world.body(item), self.world.sensor("low_shelf"))
        self.register_success_conditions([stowed, NothingGrasped(self.gripper)])
        word = item.replace("_", " ")
        return [
            f"Find shelf space in the cupboard for the {word}.",
            f"The {word} goes on the lowest shelf.",
            f"Clear the {word} away into the cupboard.",
        ]

    def _scatter(self, item: str, rng: np.random.Generator) -> None:
        """Sample all items until the hand has room around the asked one."""
        asked, bodies = self.world.body(item), [self.world.body(name) for name in self.items]
        for _ in range(ATTEMPTS):
            self.boundary.clear()
            for body in bodies:
                self.boundary.sample(body, rng, min_distance=0.1)
            gaps = [np.linalg.norm((body.position - asked.position)[:2]) for body in bodies if body is not asked]
            if min(gaps) > FREE:
                return
