"""Turn the left-most knob of an oven."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

GLOW, OFF = (1.0, 0.42, 0.08, 1.0), (1.0, 0.42, 0.08, 0.0)
SHUT = 0.05
"""How far the door may be open for the light behind its window to be seen [rad]."""


class TurnOvenOn(Task):
    """The left-most of six knobs must turn by more than 1.5 rad; the others are fixed.

    Beyond that angle the window of the oven, its pilot lamp and one plate glow.
    """

    def init_task(self) -> None:
        """Success is a turn of the knob by more than 1.5 rad."""
        self.turned = JointMoved(self.world.joint("oven/knob"), 1.5)
        self.register_success_conditions([self.turned])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Begin with a cold oven; only the place of the task varies."""
        self.world.body("oven").set_color(OFF, "glow")
        return self.make_instructions()

    def step(self) -> None:
        """Let the oven glow while its knob is turned far enough."""
        glows = self.turned.met() and self.world.joint("oven/door").position < SHUT
        self.world.body("oven").set_color(GLOW if glows else OFF, "glow")
