"""Put one grocery item on the lower shelf of a cupboard."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task, clearance

FREE = 0.15
"""Distance of the asked item from the others, so that the hand fits in [m]."""


class PutGroceriesInCupboard(Task):
    """The asked one of nine items must be on the lower shelf, let go; which way up does not matter.

    Which item is asked for varies, and where the nine stand on the table.
    """

    items = ("crackers", "chocolate_jello", "strawberry_jello", "soup", "tuna", "spam", "coffee", "mustard", "sugar")

    def init_task(self) -> None:
        """All items may be grasped."""
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(self.items)

    def variation_count(self) -> int:
        """One for each item."""
        return len(self.items)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Scatter the items, with space for the hand around the asked one; success is that it is on the shelf, let go."""
        item = self.items[variation]
        asked, bodies = self.world.body(item), [self.world.body(name) for name in self.items]
        self.boundary.scatter(bodies, rng, min_distance=0.1, accept=lambda: clearance(asked, bodies) > FREE)
        self.world.frame("waypoint1").set_parent(f"grasp_{item}")
        self.world.frame("waypoint4").set_parent(f"stow_{item}")
        stowed = Detected(asked, self.world.sensor("low_shelf"))
        self.register_success_conditions([stowed, NothingGrasped(self.gripper)])
        word = item.replace("_", " ")
        return [
            f"Find room for the {word} on the lower shelf of the cupboard.",
            f"The lower shelf of the cupboard is the place to keep the {word}.",
            f"Clear away the {word}, and use the cupboard's lower shelf for that.",
        ]
