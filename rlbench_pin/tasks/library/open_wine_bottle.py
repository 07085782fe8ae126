"""Unscrew the cap of a wine bottle and take it off."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, JointMoved, Task

LOOSE = np.deg2rad(150.0)
"""Anticlockwise rotation that releases the cap [rad]."""
HELD = ("lift", "shift_x", "shift_y", "roll", "pitch")
"""Joints of the cap that the thread holds."""


class OpenWineBottle(Task):
    """The cap must be off the neck; the thread holds it until it has been turned anticlockwise by 150 degrees."""

    def init_task(self) -> None:
        """Success is the cap off the neck."""
        self.held = [self.world.joint(f"cap/{name}") for name in HELD]
        self.turn = self.world.joint("cap/turn")
        self.loosened = JointMoved(self.turn, LOOSE)
        self.register_success_conditions([Detected(self.world.body("cap"), self.world.sensor("neck"), negated=True)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()

    def step(self) -> None:
        """Release the cap from the thread when it has been turned anticlockwise far enough."""
        if self.held[0].locked and self.loosened.met() and self.turn.position > 0.0:
            for joint in self.held:
                joint.unlock()
