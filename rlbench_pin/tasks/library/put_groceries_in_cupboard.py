"""Put one grocery item on the lower shelf of a cupboard."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task

FREE, FREE_OF_CRACKERS = 0.15, 0.18
"""Distance from the requested item to the others, and to the crackers, which are large, so that the gripper fits [m]."""


class PutGroceriesInCupboard(Task):
    """The requested one of nine items must be on the lower shelf in any orientation, and be released.

    The requested item and the places of all nine on the table vary.
    """

    items = ("crackers", "chocolate_jello", "strawberry_jello", "soup", "tuna", "spam", "coffee", "mustard", "sugar")
    packages = ("box", "box", "box", "tin", "tin", "tin", "tin", "bottle", "box")

    def init_task(self) -> None:
        """All items may be grasped."""
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(self.items)

    def variation_count(self) -> int:
        """One for each item."""
        return len(self.items)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the items, with space around the requested one; success is that item on the shelf, and an empty gripper."""
        item = self.items[variation]
        asked = self.world.body(item)
        self.boundary.clear()
        self.boundary.sample(asked, rng)
        for name in self.items:
            if name != item:
                room = FREE_OF_CRACKERS if name == "crackers" else FREE
                self.boundary.sample(self.world.body(name), rng, min_distance=0.1, apart={item: room})
        self.world.frame("waypoint1").set_parent(f"grasp_{item}")
        self.world.frame("waypoint4").set_parent(f"stow_{item}")
        stowed = Detected(asked, self.world.sensor("low_shelf"))
        self.register_success_conditions([stowed, NothingGrasped(self.gripper)])
        word = item.replace("_", " ")
        return self.make_instructions(item=word, package=f"{self.packages[variation]} of {word}")
