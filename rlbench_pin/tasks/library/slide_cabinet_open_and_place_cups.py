"""Put a cup behind one of the two sliding doors of a cabinet."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, JointMoved, NothingGrasped, Task


class SlideCabinetOpenAndPlaceCups(Task):
    """The cup must be upright on the floor of the requested half, released, and the door of this half must be open by 6 cm."""

    sides = ("left", "right")

    def init_task(self) -> None:
        """The cup may be grasped."""
        self.register_graspable_objects(["cup"])

    def variation_count(self) -> int:
        """One for each half."""
        return len(self.sides)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the requested door and at the floor behind it; success is the cup there, the door open, and an empty gripper."""
        side = self.sides[variation]
        for waypoint, place in (("waypoint1", "handle"), ("waypoint2", "slid"), ("waypoint8", "place")):
            self.world.frame(waypoint).set_parent(f"{side}_{place}")
        inside = self.world.sensor(f"inside_{side}")
        stands = [Detected(self.world.frame(f"foot{i}"), inside) for i in range(3)]
        opened = JointMoved(self.world.joint(f"cabinet/{side}_door"), 0.06)
        self.register_success_conditions([*stands, opened, NothingGrasped(self.gripper)])
        return self.make_instructions(side=side)
