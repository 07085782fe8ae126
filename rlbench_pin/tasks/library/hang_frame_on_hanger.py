"""Hang a framed picture on a hook on the wall."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class HangFrameOnHanger(Task):
    """The bar on the back of the frame must be on the hook, and the frame be released."""

    def init_task(self) -> None:
        """The frame may be grasped; success is the middle of its bar on the hook, and an empty gripper."""
        hangs = Detected(self.world.frame("bar_middle"), self.world.sensor("hook"))
        self.register_graspable_objects(["frame"])
        self.register_success_conditions([hangs, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
