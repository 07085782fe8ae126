"""Drop a small basketball through a hoop."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AllOf, Detected, InOrder, NothingGrasped, Task


class BasketballInHoop(Task):
    """The ball, released by the gripper, must pass down through the ring, to just below it; it may roll away afterwards."""

    def init_task(self) -> None:
        """The ball may be grasped; success is its passage down through the ring."""
        ball, world = self.world.body("ball"), self.world
        self.register_graspable_objects(["ball"])
        above = Detected(world.frame("middle"), world.sensor("above"))
        through = AllOf([Detected(ball, world.sensor("goal")), NothingGrasped(self.gripper)])
        self.register_success_conditions([InOrder([above, through])])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
