"""Take a cube out of one drawer of a chest."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class TakeItemOutOfDrawer(Task):
    """The cube must be on top of the chest; it may still be held. It starts in the requested one of three shut drawers."""

    drawers = ("bottom", "middle", "top")

    def init_task(self) -> None:
        """The cube may be grasped; success is the cube on top of the chest."""
        self.cube = self.world.body("cube")
        self.register_graspable_objects(["cube"])
        self.register_success_conditions([Detected(self.cube, self.world.sensor("top_side"))])

    def variation_count(self) -> int:
        """One for each drawer."""
        return len(self.drawers)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Put the cube into the requested drawer, and aim at the handle of this drawer."""
        drawer = self.drawers[variation]
        self.world.frame("waypoint1").move_to(f"handle_{drawer}")
        self.cube.set_pose(self.world.frame(f"inside_{drawer}").pose)
        return self.make_instructions(drawer=drawer)
