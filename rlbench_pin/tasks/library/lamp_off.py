"""Switch a lamp off."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import JointMoved, Task

BRIGHT = {"bulb": (1.0, 0.97, 0.88), "shade": (0.88, 0.71, 0.44)}
DARK = {"bulb": (0.80, 0.79, 0.76), "shade": (0.93, 0.85, 0.73)}
"""Link of the lamp -> its colour while the lamp is on, and while it is off."""
ENAMEL = (0.05, 0.22, 0.26)
"""The base of the button, in the colour of the foot of the lamp."""


class LampOff(Task):
    """The button of a lit lamp must go down by 3 mm; the lamp is off from then on."""

    def init_task(self) -> None:
        """Success is the button pressed."""
        self.lamp = self.world.body("lamp")
        self.pressed = JointMoved(self.world.joint("button/cap_joint"), 0.003)
        self.register_success_conditions([self.pressed])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Switch the lamp on; only the placement of the task varies."""
        self._shine(BRIGHT)
        self.world.body("button").set_color(ENAMEL, "base")
        return self.make_instructions()

    def step(self) -> None:
        """Switch the lamp off when its button is pressed."""
        if self.pressed.met():
            self._shine(DARK)

    def _shine(self, colors: dict[str, tuple[float, float, float]]) -> None:
        for link, rgb in colors.items():
            self.lamp.set_color(rgb, link)
