"""Fetch a cube out of one drawer of a chest."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class TakeItemOutOfDrawer(Task):
    """The cube must come from the asked one of three shut drawers to the top of the chest; it need not be let go."""

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
        """Put the cube into the asked drawer, and aim at its handle."""
        drawer = self.drawers[variation]
        self.world.frame("waypoint1").move_to(f"handle_{drawer}")
        self.cube.set_pose(self.world.frame(f"inside_{drawer}").pose)
        return self.make_instructions(drawer=drawer)
