"""Turn the handle of a window and push its left wing open."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task


class OpenWindow(Task):
    """The left wing must swing by 30 degrees; it is latched until its handle has been turned by 80 degrees."""

    def init_task(self) -> None:
        """Success is a swing of the wing by 30 degrees."""
        self.wing = self.world.joint("window/wing_hinge")
        self.unlatched = JointMoved(self.world.joint("window/handle"), np.deg2rad(80.0))
        self.register_success_conditions([JointMoved(self.wing, np.deg2rad(30.0))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()

    def step(self) -> None:
        """Unlatch the wing when the handle has been turned far enough."""
        if self.wing.locked and self.unlatched.met():
            self.wing.unlock()
