"""Turn one of the two handles of a tap."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

RUNNING, SHUT = (0.60, 0.82, 0.96, 0.6), (0.60, 0.82, 0.96, 0.0)


class TurnTap(Task):
    """The requested handle must rotate by more than a quarter turn in either direction.

    Left and right are seen with the spout in front. Water runs while the requested handle is turned that far.
    """

    sides = ("left", "right")

    def variation_count(self) -> int:
        """One for each handle."""
        return len(self.sides)

    def init_task(self) -> None:
        """Register nothing: the tap has no graspable object."""

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the requested handle; success is its rotation."""
        side = self.sides[variation]
        self.world.frame("waypoint1").set_parent(f"{side}_grip")
        self.open = JointMoved(self.world.joint(f"tap/{side}"), 1.57)
        self.register_success_conditions([self.open])
        self.world.body("tap").set_color(SHUT, "stream")
        return self.make_instructions(side=side)

    def step(self) -> None:
        """Show the water while the handle is open."""
        self.world.body("tap").set_color(RUNNING if self.open.met() else SHUT, "stream")
