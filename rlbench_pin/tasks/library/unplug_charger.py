"""Pull a charger out of a wall socket."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class UnplugCharger(Task):
    """The charger must be in front of the socket, with its pins out of the holes; it may still be held."""

    def init_task(self) -> None:
        """The charger may be grasped; success is that it is away from the wall."""
        self.register_graspable_objects(["charger"])
        self.register_success_conditions([Detected(self.world.body("charger"), self.world.sensor("away"))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
