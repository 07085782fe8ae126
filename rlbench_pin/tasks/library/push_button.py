"""Press a button."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import BUTTON_COLORS, InOrder, JointMoved, Task

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


class PushButton(Task):
    """The red cap must go down by 3 mm once; it then turns green. The colour of the base varies."""

    def init_task(self) -> None:
        """Success is that the cap has been pressed once."""
        self.button = self.world.body("button")
        self.pressed = InOrder([JointMoved(self.world.joint("button/cap_joint"), 0.003)])
        self.register_success_conditions([self.pressed])

    def variation_count(self) -> int:
        """One for each colour of the base."""
        return len(BUTTON_COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour the base; the cap is red."""
        name, rgb = BUTTON_COLORS[variation]
        self.is_green = False
        self.button.set_color(rgb, link="base")
        self.button.set_color(RED, link="cap")
        return self.make_instructions(name=name)

    def step(self) -> None:
        """Turn the cap green when it is pressed for the first time."""
        if not self.is_green and self.pressed.met():
            self.is_green = True
            self.button.set_color(GREEN, link="cap")
