"""Take a folded umbrella out of its stand."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class TakeUmbrellaOutOfUmbrellaStand(Task):
    """The whole umbrella must be outside the stand; it may still be held."""

    def init_task(self) -> None:
        """The umbrella may be grasped; success is that no part of it is in the stand."""
        self.register_graspable_objects(["umbrella"])
        inside = self.world.sensor("inside")
        self.register_success_conditions([Detected(self.world.body("umbrella"), inside, negated=True)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
