"""Build a tower of four blocks of different colours."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, fill_up_colors
from rlbench_pin.tasks.library.stack_blocks import StackBlocks


class Tower4(StackBlocks):
    """Four blocks of different colours must be stacked on the green square in the requested order, and be released.

    Four more blocks have a fifth colour. All eight start at random places in four patches around the square.
    """

    height, sets = 4, 5
    """Blocks of the tower, and sets of colours that differ altogether."""

    def variation_count(self) -> int:
        """One for each set of colours in its order, then one for each in the reverse order."""
        return 2 * self.sets

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the blocks; success is each of the four on its level of the tower, and an empty gripper."""
        asked = COLORS[variation % self.sets :: self.sets][:: 1 if variation < self.sets else -1]
        *_, other = fill_up_colors(rng, asked, self.height + 1, COLORS)
        for block, color in zip(self.blocks, asked, strict=True):
            block.set_color(color.rgb)
        for distractor in self.distractors:
            distractor.set_color(other.rgb)
        self.boundary.scatter([*self.blocks, *self.distractors], rng, min_distance=0.1)
        levels = [Detected(block, self.world.sensor(f"level{k}")) for k, block in enumerate(self.blocks)]
        self.register_success_conditions([*levels, NothingGrasped(self.gripper)])
        self.register_rounds(self.height)
        a, b, c, d = (color.name for color in asked)
        return self.make_instructions(a=a, b=b, c=c, d=d)
