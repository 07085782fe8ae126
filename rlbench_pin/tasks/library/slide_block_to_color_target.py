"""Push a block onto the square of one colour; a variant of `slide_block_to_target`, not one of the paper's 106 tasks."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task


class SlideBlockToColorTarget(Task):
    """The red block must reach the middle of the square of the requested colour. The squares are around it in random order.

    The block cannot be grasped.
    """

    colors = ("green", "blue", "pink", "yellow")

    def init_task(self) -> None:
        """Find the squares; the block may only be pushed."""
        self.block = self.world.body("block")
        self.squares = [self.world.body(name) for name in self.colors]

    def variation_count(self) -> int:
        """One for each colour."""
        return len(self.colors)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Shuffle the squares; success is the block on the middle of the requested square."""
        color, places = self.colors[variation], rng.permutation([square.pose for square in self.squares])
        for square, place in zip(self.squares, places, strict=True):
            square.set_pose(place)
        self.world.frame("waypoint0").set_parent(color)
        self.register_success_conditions([Detected(self.block, self.world.sensor(f"on_{color}"))])
        return self.make_instructions(color=color)
