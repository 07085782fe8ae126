"""Turn the leftmost knob of an oven."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

GLOW, OFF = (1.0, 0.42, 0.08, 1.0), (1.0, 0.42, 0.08, 0.0)
SHUT = 0.05
"""Largest angle of the door at which the light behind its window is visible [rad]."""


class TurnOvenOn(Task):
    """The leftmost of six knobs must rotate by more than 1.5 rad; the others are fixed.

    Beyond this angle the window of the oven, its pilot lamp and one plate glow.
    """

    def init_task(self) -> None:
        """Success is a rotation of the knob by more than 1.5 rad."""
        self.turned = JointMoved(self.world.joint("oven/knob"), 1.5)
        self.register_success_conditions([self.turned])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Switch the oven off; only the placement of the task varies."""
        self.world.body("oven").set_color(OFF, "glow")
        return self.make_instructions()

    def step(self) -> None:
        """Show the glow of the oven while its knob is turned far enough."""
        glows = self.turned.met() and self.world.joint("oven/door").position < SHUT
        self.world.body("oven").set_color(GLOW if glows else OFF, "glow")
