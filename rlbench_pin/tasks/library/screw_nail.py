"""Turn a screw with a screwdriver."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Grasped, InOrder, JointMoved, Task


class ScrewNail(Task):
    """The gripper must grasp the screwdriver; after that, the screw must rotate by more than 1.4 rad in either direction."""

    def init_task(self) -> None:
        """The screwdriver may be grasped; success is a grasp, then a rotation of the screw by 1.4 rad."""
        self.register_graspable_objects(["screwdriver"])
        held = Grasped(self.gripper, self.world.body("screwdriver"))
        self.turned = JointMoved(self.world.joint("block/screw"), 1.4)
        self.driven = InOrder([held, self.turned])
        self.register_success_conditions([self.driven])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()

    def step(self) -> None:
        """Measure the rotation of the screw from the first grasp of the screwdriver."""
        if self.driven.passed == 0:
            self.turned.reset()
