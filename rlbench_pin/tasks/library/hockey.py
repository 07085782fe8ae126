"""Strike a ball into a goal with a hockey stick."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Grasped, Task


class Hockey(Task):
    """The ball must be behind the goal line while the gripper holds the stick."""

    def init_task(self) -> None:
        """The stick may be grasped; success is the ball behind the goal line while the gripper holds the stick."""
        stick, ball = self.world.body("stick"), self.world.body("ball")
        self.register_graspable_objects(["stick"])
        self.register_success_conditions([Detected(ball, self.world.sensor("behind_line")), Grasped(self.gripper, stick)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
