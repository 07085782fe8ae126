"""Build a pyramid of six blocks of one colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, DetectedSeveral, NothingGrasped, SpawnBoundary, Task, Waypoint, distractor_colors

BLOCKS = 6
"""Number of blocks of the requested colour, and of the other colour."""
LAYERS = {"low": 3, "mid": 2, "top": 1}
"""Blocks in each layer."""
APART, ROOM = 0.08, 0.096
"""Least distance between two blocks, and from a requested block to any other, so that the open gripper fits [m]."""
LOWEST, HIGHEST = (0.0, 0.0, -np.pi / 4.0), (0.0, 0.0, np.pi / 4.0)
"""Bounds of the rotation of a block [rad]."""


class BlockPyramid(Task):
    """Six blocks of the requested colour must be stacked on the marked strip in layers of three, two and one, and be released.

    Six more blocks have another colour. All twelve start at random places in four patches around the strip.
    """

    def init_task(self) -> None:
        """All twelve blocks may be grasped; each round moves the next block to the next place.

        The blocks nearest to the strip come first, because the gripper has no space beside a high pyramid.
        """
        self.blocks = [self.world.body(f"block{i}") for i in range(BLOCKS)]
        self.distractors = [self.world.body(f"distractor{i}") for i in range(BLOCKS)]
        self.order = list(self.blocks)
        self.boundary = SpawnBoundary([self.world.region(f"patch{i}") for i in range(4)])
        self.register_graspable_objects(body.name for body in (*self.blocks, *self.distractors))
        self.register_waypoint_ability_start(0, self._aim_at_next_block)
        self.register_waypoint_ability_start(5, self._stay_after_last_block)
        layers = [DetectedSeveral(self.blocks, self.world.sensor(name), count) for name, count in LAYERS.items()]
        self.register_success_conditions([*layers, NothingGrasped(self.gripper)])

    def variation_count(self) -> int:
        """One for each colour."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Set the colours and random places of the blocks."""
        self.register_rounds(BLOCKS)
        name, rgb = COLORS[variation]
        other = distractor_colors(rng, variation, 1)[0].rgb
        for bodies, color in ((self.blocks, rgb), (self.distractors, other)):
            for body in bodies:
                body.set_color(color)
        room = {block.name: ROOM for block in self.blocks}
        self.boundary.clear()
        for body in (*self.blocks, *self.distractors):
            self.boundary.sample(body, rng, min_rotation=LOWEST, max_rotation=HIGHEST, min_distance=APART, apart=room)
        middle = self.world.body("strip").position
        self.order = sorted(self.blocks, key=lambda block: float(np.linalg.norm(block.position - middle)))
        return self.make_instructions(color=name)

    def _aim_at_next_block(self, waypoint: Waypoint) -> None:
        self.world.frame("waypoint1").set_parent(self.order[self.round].name)
        self.world.frame("waypoint4").set_parent(f"place{self.round}")

    def _stay_after_last_block(self, waypoint: Waypoint) -> None:
        waypoint.skip = self.round == BLOCKS - 1
