"""Turn a screw with a screwdriver."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Grasped, InOrder, JointMoved, Task


class ScrewNail(Task):
    """The screwdriver must have been grasped, then the screw must turn by more than 1.4 rad."""

    def init_task(self) -> None:
        """The screwdriver may be grasped; success is a grasp, then a turn of the screw by 1.4 rad."""
        self.register_graspable_objects(["screwdriver"])
        held = Grasped(self.gripper, self.world.body("screwdriver"))
        self.turned = JointMoved(self.world.joint("block/screw"), 1.4)
        self.driven = InOrder([held, self.turned])
        self.register_success_conditions([self.driven])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()

    def step(self) -> None:
        """Count the turn of the screw from when the screwdriver is first held."""
        if self.driven.passed == 0:
            self.turned.reset()
