"""Put a plate between the pegs of the requested colour in a dish rack."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, SpawnBoundary, Task, distractor_colors

LANES = 3
TURN = (0.0, 0.0, 0.5)
"""Bounds of the yaw of the stand of the plate [rad]."""


class PutPlateInColoredDishRack(Task):
    """The plate must stand in the requested one of three lanes, and be released.

    The requested colour, the lane of this colour, the colours of the other two lanes, and the places of stand and rack vary.
    """

    def init_task(self) -> None:
        """The plate may be grasped; success is the plate in the lane, and an empty gripper."""
        self.rack, self.stand = self.world.body("rack"), self.world.body("stand")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["plate"])
        in_lane = Detected(self.world.body("plate"), self.world.sensor("lane"))
        self.register_success_conditions([in_lane, NothingGrasped(self.gripper)])

    def variation_count(self) -> int:
        """One for each colour of the lane."""
        return len(COLORS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw the goal lane, colour all three lanes, and place the stand with the plate, and the rack."""
        colors = (COLORS[variation], *distractor_colors(rng, variation, LANES - 1))
        goal, *others = rng.permutation(LANES)
        for lane, (_, rgb) in zip((goal, *others), colors, strict=True):
            self.rack.set_color(rgb, f"lane{lane}")
        self.world.sensor("lane").set_parent(f"lane{goal}")
        self.patch.clear()
        self.patch.sample(self.stand, rng, min_rotation=TURN, max_rotation=TURN)
        self.patch.sample(self.rack, rng, min_distance=0.2)
        name = colors[0].name
        return self.make_instructions(color=name)
