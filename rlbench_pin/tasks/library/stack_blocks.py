"""Build a tower of blocks of one colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, DetectedSeveral, NothingGrasped, SpawnBoundary, Task, Waypoint, distractor_colors

CUBE = 0.05
"""Side of a block [m]."""
NUMBER = {2: "two", 3: "three", 4: "four"}
"""Number of blocks in the tower, in words."""
CLEARANCE = 0.08
"""Height of the gripper above the tower before it releases a block [m]."""


class StackBlocks(Task):
    """Two to four of the four blocks of the requested colour must be stacked on the green square, and be released.

    Four more blocks have another colour. All eight start at random places in four patches around the square.
    """

    def init_task(self) -> None:
        """All eight blocks may be grasped; each round aims at the next one."""
        self.blocks = [self.world.body(f"block{i}") for i in range(4)]
        self.distractors = [self.world.body(f"distractor{i}") for i in range(4)]
        self.boundary = SpawnBoundary([self.world.region(f"patch{i}") for i in range(4)])
        self.register_graspable_objects(body.name for body in (*self.blocks, *self.distractors))
        self.register_waypoint_ability_start(0, self._aim_at_next_block)
        self.register_waypoint_ability_start(3, self._rise_over_tower)
        self.register_waypoint_ability_start(5, self._stay_after_last_block)

    def variation_count(self) -> int:
        """One for each colour and height of the tower."""
        return 3 * len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour and place the blocks; success is a requested block on each level of the tower, and an empty gripper."""
        color, self.height = variation // 3, 2 + variation % 3
        name, rgb = COLORS[color]
        other = distractor_colors(rng, color, 1)[0].rgb
        for bodies, body_color in ((self.blocks, rgb), (self.distractors, other)):
            for body in bodies:
                body.set_color(body_color)
        self.boundary.scatter([*self.blocks, *self.distractors], rng, min_distance=0.1)
        tower = DetectedSeveral(self.blocks, self.world.sensor("column"), self.height)
        levels = [DetectedSeveral(self.blocks, self.world.sensor(f"level{k}"), 1) for k in range(self.height)]
        self.register_success_conditions([tower, *levels, NothingGrasped(self.gripper)])
        self.register_rounds(self.height)
        number = NUMBER[self.height]
        return self.make_instructions(number=number, name=name)

    def _aim_at_next_block(self, waypoint: Waypoint) -> None:
        self.world.frame("waypoint1").set_parent(f"block{self.round}")

    def _rise_over_tower(self, waypoint: Waypoint) -> None:
        x, y, z = self.world.body("square").position
        waypoint.frame.set_position([x, y, z + CLEARANCE + CUBE * self.round])

    def _stay_after_last_block(self, waypoint: Waypoint) -> None:
        waypoint.skip = self.round == self.height - 1
