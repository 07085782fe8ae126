"""Put a cube into one drawer of a chest."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class PutItemInDrawer(Task):
    """The cube on top of the chest must be in the requested one of three drawers, all shut at the start; it may still be held."""

    drawers = ("bottom", "middle", "top")

    def init_task(self) -> None:
        """The cube may be grasped."""
        self.register_graspable_objects(["cube"])

    def variation_count(self) -> int:
        """One for each drawer."""
        return len(self.drawers)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the handle of the requested drawer; success is the cube in this drawer."""
        drawer = self.drawers[variation]
        self.world.frame("waypoint1").move_to(f"handle_{drawer}")
        self.register_success_conditions([Detected(self.world.body("cube"), self.world.sensor(f"in_{drawer}"))])
        return self.make_instructions(drawer=drawer)
