"""Drag a cube onto a coloured square with a stick."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, Task


class ReachAndDrag(Task):
    """The cube must reach the middle of the square, whose colour varies."""

    def init_task(self) -> None:
        """The stick may be grasped; success is the cube on the middle of the square."""
        self.register_graspable_objects(["stick"])
        self.register_success_conditions([Detected(self.world.body("cube"), self.world.sensor("square"))])

    def variation_count(self) -> int:
        """One for each colour of the square."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour the square."""
        name, rgb = COLORS[variation]
        self.world.body("target").set_color(rgb)
        return self.make_instructions(color=name)
