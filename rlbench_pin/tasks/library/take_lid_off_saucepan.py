"""Lift the lid off a saucepan."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Grasped, Task


class TakeLidOffSaucepan(Task):
    """The lid must be held by its knob, well above the pan."""

    def init_task(self) -> None:
        self.lid, self.above = self.world.body("lid"), self.world.sensor("above")
        self.register_graspable_objects(["lid"])
        self.register_success_conditions([Grasped(self.gripper, self.lid), Detected(self.lid, self.above)])

    def variation_count(self) -> int:
        return 1

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        return [
            "Lift the cover from the pot.",
            "Let the steam out, raise the saucepan's lid.",
            "Hold the pot's lid up in the air.",
        ]

    def reward(self) -> float:
        knob = self.lid.position
        to_knob = np.linalg.norm(self.robot.tip_pose()[:3] - knob)
        to_goal = np.linalg.norm(knob - self.above.pose[:3])
        return -float(to_knob) - float(to_goal)
