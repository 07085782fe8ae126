"""Lift a cylinder to a floating marker."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, fill_up_colors
from rlbench_pin.tasks.library.pick_and_lift import PickAndLift


class PickAndLiftCylinder(PickAndLift):
    """The cylinder must be held at the marker. It, two cubes and the marker stand anywhere in a rectangle."""

    lifted = "toy"
    word = "cylinder"
    """What instructions call the toy."""

    def variation_count(self) -> int:
        """One: the toy alone has its shape."""
        return 1

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour the two cubes, then place marker, toy and cubes."""
        for cube, color in zip(self.distractors, fill_up_colors(rng, (), len(self.distractors), COLORS), strict=True):
            cube.set_color(color.rgb)
        self.scatter(rng)
        return [
            f"Lift the {self.word} until it is in the floating ring.",
            f"There is a ring in the air: carry the {self.word} into it.",
            f"Up where the ring floats, hold the {self.word}.",
        ]
