"""Move a cube onto a coloured square with a stick."""

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
        return [
            f"Drag the cube onto the middle of the {name} square with the stick.",
            f"The wooden block must get to the centre of the {name} field: use the rod to push it there.",
            f"With the stick in hand, move the cube over to the middle of the {name} area.",
        ]
