"""Put three items into one drawer of a chest, one after another."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AllOf, Detected, InOrder, NothingGrasped, Task, Waypoint


class PutItemsInDrawer(Task):
    """Cube, cylinder and star must be put into the requested one of three drawers, in the requested order.

    The items start on the chest, the drawers are shut. An item that is put in too early must be taken out again.
    At the end all three items must be in the drawer, and be released.
    """

    drawers = ("bottom", "middle", "top")
    orders = (("cube", "cylinder", "star"), ("star", "cylinder", "cube"))

    def init_task(self) -> None:
        """The items may be grasped; the first round opens the drawer, and each round puts the next item into it."""
        self.order = self.orders[0]
        self.register_graspable_objects(self.order)
        for opening in range(4):
            self.register_waypoint_ability_start(opening, self._open_once)
        self.register_waypoint_ability_start(4, self._aim_at_next_item)

    def variation_count(self) -> int:
        """One for each drawer and order."""
        return len(self.drawers) * len(self.orders)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the handle of the requested drawer; success is that the items were put into it in order, and are still there."""
        drawer, self.order = self.drawers[variation // len(self.orders)], self.orders[variation % len(self.orders)]
        self.world.frame("waypoint1").move_to(f"handle_{drawer}")
        inside, outside = (
            [Detected(self.world.body(item), self.world.sensor(f"in_{drawer}"), negated=negated) for item in self.order]
            for negated in (False, True)
        )
        stages = [AllOf([*inside[: k + 1], *outside[k + 1 :]]) for k in range(len(self.order))]
        self.register_success_conditions([InOrder(stages), *inside, NothingGrasped(self.gripper)])
        self.register_rounds(len(self.order))
        first, second, third = self.order
        return self.make_instructions(drawer=drawer, first=first, second=second, third=third)

    def _open_once(self, waypoint: Waypoint) -> None:
        waypoint.skip = self.round > 0

    def _aim_at_next_item(self, waypoint: Waypoint) -> None:
        self.world.frame("waypoint5").set_parent(f"grasp_{self.order[self.round]}")
        self.world.frame("waypoint8").set_parent(f"place{self.round}")
