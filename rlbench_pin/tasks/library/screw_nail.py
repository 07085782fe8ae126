"""Turn a screw with a screwdriver."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Grasped, InOrder, JointMoved, Task

ARROW, DONE = (0.95, 0.93, 0.86), (0.15, 0.95, 0.25)


class ScrewNail(Task):
    """The screwdriver must have been grasped, then the screw must turn by more than 1.4 rad.

    The arrow on the block shines once that is done.
    """

    def init_task(self) -> None:
        """The screwdriver may be grasped; success is a grasp, then a turn of the screw by 1.4 rad."""
        self.register_graspable_objects(["screwdriver"])
        held = Grasped(self.gripper, self.world.body("screwdriver"))
        self.turned = JointMoved(self.world.joint("block/screw"), 1.4)
        self.driven = InOrder([held, self.turned])
        self.register_success_conditions([self.driven])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Begin with a pale arrow; only the place of the task varies."""
        self.world.body("block").set_color(ARROW, "dial")
        return [
            "Take the screwdriver and give the screw in the block a quarter turn.",
            "The screw needs another 90 degrees, so grip the screwdriver and turn it.",
            "Use the screwdriver to rotate the block's screw by a quarter.",
        ]

    def step(self) -> None:
        """Count the turn of the screw from when the screwdriver is first held; let the arrow shine when it is enough."""
        if self.driven.passed == 0:
            self.turned.reset()
        self.world.body("block").set_color(DONE if self.driven.passed and self.turned.met() else ARROW, "dial")
