"""Drop a small basketball through a hoop."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AllOf, Detected, InOrder, NothingGrasped, Task


class BasketballInHoop(Task):
    """The ball must come from above the ring to right below it, let go; afterwards it may roll away."""

    def init_task(self) -> None:
        """The ball may be grasped; success is its way through the ring, downwards."""
        ball, world = self.world.body("ball"), self.world
        self.register_graspable_objects(["ball"])
        above = Detected(world.frame("middle"), world.sensor("above"))
        through = AllOf([Detected(ball, world.sensor("goal")), NothingGrasped(self.gripper)])
        self.register_success_conditions([InOrder([above, through])])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()
