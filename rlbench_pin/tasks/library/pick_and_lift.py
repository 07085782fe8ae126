"""Lift one of three blocks to a floating marker."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, NO_ROTATION, Detected, Grasped, SpawnBoundary, Task, distractor_colors


class PickAndLift(Task):
    """The gripper must hold the block of the requested colour at the marker. Blocks and marker start at random places."""

    def init_task(self) -> None:
        """The block may be grasped; success is that the gripper holds it at the marker."""
        self.block, self.marker = self.world.body("block"), self.world.body("marker")
        self.distractors = [self.world.body("distractor0"), self.world.body("distractor1")]
        self.boundary = SpawnBoundary([self.world.region("boundary")])
        self.register_graspable_objects(["block"])
        self.register_success_conditions([Grasped(self.gripper, self.block), Detected(self.block, self.world.sensor("goal"))])

    def variation_count(self) -> int:
        """One for each colour of the block."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the marker, then colour and place the three blocks."""
        name, rgb = COLORS[variation]
        others = distractor_colors(rng, variation, len(self.distractors))
        self.boundary.clear()
        self.boundary.sample(self.marker, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION)
        for block, color in zip([self.block, *self.distractors], [rgb, *(c.rgb for c in others)], strict=True):
            block.set_color(color)
            self.boundary.sample(block, rng, min_distance=0.1)
        return self.make_instructions(color=name)

    def get_low_dim_state(self) -> np.ndarray:
        """Return the positions of block and marker, shape (6,) [m]."""
        return np.concatenate([self.block.position, self.marker.position])
