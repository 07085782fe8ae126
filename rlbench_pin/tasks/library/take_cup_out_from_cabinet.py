"""Take a cup out of one half of a cabinet with sliding doors."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class TakeCupOutFromCabinet(Task):
    """The cup must be upright on the table, and be released. It starts behind the requested one of two shut doors."""

    sides = ("left", "right")

    def init_task(self) -> None:
        """The cup may be grasped; success is the cup upright on the table outside the cabinet, and an empty gripper."""
        self.cup, on_table = self.world.body("cup"), self.world.sensor("on_table")
        self.register_graspable_objects(["cup"])
        out = Detected(self.cup, self.world.sensor("inside"), negated=True)
        stands = [Detected(self.world.frame(f"foot{i}"), on_table) for i in range(3)]
        self.register_success_conditions([out, *stands, NothingGrasped(self.gripper)])

    def variation_count(self) -> int:
        """One for each half."""
        return len(self.sides)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Put the cup into the requested half, and aim at the handle of its door."""
        side = self.sides[variation]
        self.cup.set_pose(self.world.frame(f"{side}_place").pose)
        self.world.frame("waypoint1").set_parent(f"{side}_handle")
        self.world.frame("waypoint2").set_parent(f"{side}_slid")
        return self.make_instructions(side=side)
