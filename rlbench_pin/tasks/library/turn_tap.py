"""Turn one of the two handles of a tap."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

RUNNING, SHUT = (0.60, 0.82, 0.96, 0.6), (0.60, 0.82, 0.96, 0.0)


class TurnTap(Task):
    """The asked handle must be turned by more than a quarter, either way; left and right are seen with the spout in front.

    Water runs while the asked handle is turned that far.
    """

    sides = ("left", "right")

    def variation_count(self) -> int:
        """One for each handle."""
        return len(self.sides)

    def init_task(self) -> None:
        """Nothing can be taken."""

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the asked handle; success is that it is turned."""
        side = self.sides[variation]
        self.world.frame("waypoint1").set_parent(f"{side}_grip")
        self.open = JointMoved(self.world.joint(f"tap/{side}"), 1.57)
        self.register_success_conditions([self.open])
        self.world.body("tap").set_color(SHUT, "stream")
        return self.make_instructions(side=side)

    def step(self) -> None:
        """Let the water run while the handle is open."""
        self.world.body("tap").set_color(RUNNING if self.open.met() else SHUT, "stream")
