"""Hang a coat hanger on a clothes rail."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task


class PlaceHangerOnRack(Task):
    """The hanger must hang on the rail by its hook, and be released. It starts in a stand at a random place beside the rail.

    It hangs if the top of its hook is on the rail and its lower bar is below the rail.
    """

    def init_task(self) -> None:
        """The hanger may be grasped; success is that it hangs on the rail with an empty gripper."""
        self.stand, hanger = self.world.body("stand"), self.world.body("hanger")
        self.boundary = SpawnBoundary([self.world.region("patch")])
        on_rail = Detected(hanger, self.world.sensor("rail"))
        top = Detected(self.world.frame("hook_top"), self.world.sensor("rail_top"))
        below = Detected(self.world.frame("bar_middle"), self.world.sensor("below_rail"))
        self.register_graspable_objects(["hanger"])
        self.register_success_conditions([on_rail, top, below, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the stand with the hanger."""
        self.boundary.scatter([self.stand], rng)
        return self.make_instructions()
