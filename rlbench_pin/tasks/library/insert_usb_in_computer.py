"""Push a memory stick into the port of a computer."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class InsertUsbInComputer(Task):
    """The tip of the stick must be at the rear of the port in the front of the computer; it may still be held."""

    def init_task(self) -> None:
        """The stick may be grasped; success is the stick at the rear of the port, where only its tip fits."""
        self.register_graspable_objects(["stick"])
        self.register_success_conditions([Detected(self.world.body("stick"), self.world.sensor("port"))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
