"""Move a coat hanger from one clothes rail to another."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class MoveHanger(Task):
    """The hanger must hang on the second rail by its hook, and be released. Its start position on the first rail varies.

    It hangs if the top of its hook is on the rail and its lower bar is below the rail.
    """

    def init_task(self) -> None:
        """The hanger may be grasped; success is that it hangs on the second rail with an empty gripper."""
        self.hanger = self.world.body("hanger")
        on_rail = Detected(self.hanger, self.world.sensor("other_rail"))
        top = Detected(self.world.frame("hook_top"), self.world.sensor("rail_top"))
        below = Detected(self.world.frame("bar_middle"), self.world.sensor("below_rail"))
        self.register_graspable_objects(["hanger"])
        self.register_success_conditions([on_rail, top, below, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Shift the hanger along its rail."""
        pose = self.hanger.pose
        pose[0] += rng.uniform(-0.1, 0.3)
        self.hanger.set_pose(pose)
        return self.make_instructions()
