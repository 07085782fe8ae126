"""Slide one of the two doors of a cabinet open."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, NothingGrasped, Task


class SlideCabinetOpen(Task):
    """The requested door must slide by 6 cm towards the middle."""

    sides = ("right", "left")

    def init_task(self) -> None:
        """Register nothing: the side is known only in `init_episode`."""

    def variation_count(self) -> int:
        """One for each door."""
        return len(self.sides)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the handle of the requested door and slide it to the middle; success is that it moves by 6 cm."""
        side = self.sides[variation]
        self.world.frame("waypoint1").set_parent(f"{side}_handle")
        self.world.frame("waypoint2").set_parent(f"{side}_slid")
        opened = JointMoved(self.world.joint(f"cabinet/{side}_door"), 0.06)
        self.register_success_conditions([opened, NothingGrasped(self.gripper)])
        return self.make_instructions(side=side)
