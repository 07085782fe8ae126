"""Take mugs off a mug tree and put them on the table."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AllOf, AnyOf, Condition, Detected, Grasped, InOrder, NothingGrasped, Task, Waypoint

NUMBER = ("one mug", "two mugs")


class RemoveCups(Task):
    """One or two of three identical mugs must be carried to the table, be upright on it, and be released; any mug counts.

    A mug does not count if it was knocked off the tree, or dropped from more than 3 cm.
    """

    def init_task(self) -> None:
        """All mugs may be grasped; each round aims at the next one."""
        self.register_graspable_objects(f"mug{i}" for i in range(3))
        self.register_waypoint_ability_start(0, self._aim_at_next_mug)

    def variation_count(self) -> int:
        """One for each number of mugs."""
        return len(NUMBER)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Register one round for each mug; success is the requested number of mugs on the table, and an empty gripper."""
        self.register_rounds(variation + 1)
        stands = [self._set_down(f"mug{i}") for i in range(3)]
        pairs = [AllOf([stands[i], stands[k]]) for i, k in ((0, 1), (0, 2), (1, 2))]
        self.register_success_conditions([AnyOf((stands, pairs)[variation]), NothingGrasped(self.gripper)])
        number, it, each = NUMBER[variation], ("it", "them")[variation], ("the mug", "each mug")[variation]
        return self.make_instructions(number=number, it=it, each=each)

    def _set_down(self, mug: str) -> Condition:
        """Return the condition that a mug was held within 3 cm of the table, and is now upright on it."""
        near, on_table = self.world.sensor("near_table"), self.world.sensor("on_table")
        feet = [self.world.frame(f"{mug}_foot{k}") for k in range(3)]
        carried = InOrder([AllOf([Grasped(self.gripper, self.world.body(mug)), Detected(feet[0], near)])])
        return AllOf([carried, *(Detected(foot, on_table) for foot in feet)])

    def _aim_at_next_mug(self, waypoint: Waypoint) -> None:
        """Aim at the mug of this round, with the same grasp, at the pose beside its spoke, and at the next spot."""
        self.world.frame("waypoint1").set_parent(f"grasp{self.round}")
        self.world.frame("waypoint2").set_parent(f"pulled{self.round}")
        self.world.frame("waypoint4").set_parent(f"spot{self.round}")
