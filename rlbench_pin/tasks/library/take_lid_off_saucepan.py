"""Lift the lid off a saucepan."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Grasped, Task


class TakeLidOffSaucepan(Task):
    """The gripper must hold the lid by its knob in a zone above the pan."""

    def init_task(self) -> None:
        """The lid may be grasped; success is that the gripper holds it above the pan."""
        self.lid, self.above = self.world.body("lid"), self.world.sensor("above")
        self.register_graspable_objects(["lid/knob"])
        self.register_success_conditions([Grasped(self.gripper, self.lid), Detected(self.lid, self.above)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()

    def reward(self) -> float:
        """Return minus the distances from tip to knob and from knob to goal [m]."""
        knob = self.lid.position
        to_knob = np.linalg.norm(self.robot.tip_pose()[:3] - knob)
        to_goal = np.linalg.norm(knob - self.above.pose[:3])
        return -float(to_knob) - float(to_goal)
