"""Take a plate out of a dish rack and put it on a mat."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, Task


class TakePlateOffColoredDishRack(Task):
    """The plate must be out of the rack, lie on the mat, and be released.

    It starts in the requested one of three lanes, between black, red or purple pegs.
    """

    colors = ("black", "red", "purple")

    def init_task(self) -> None:
        """The plate may be grasped; success is the plate out of the rack and flat on the mat, and an empty gripper."""
        plate = self.world.body("plate")
        self.register_graspable_objects(["plate"])
        off = Detected(plate, self.world.sensor("rack_space"), negated=True)
        lies = Detected(self.world.frame("middle"), self.world.sensor("mark"))
        self.register_success_conditions([off, lies, NothingGrasped(self.gripper)])

    def variation_count(self) -> int:
        """One for each lane."""
        return len(self.colors)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour the lanes, and put the plate into the requested lane."""
        rgb = {color.name: color.rgb for color in COLORS}
        for number, color in enumerate(self.colors):
            self.world.body("rack").set_color(rgb[color], f"lane{number}")
        plate, lane = self.world.body("plate"), self.world.frame(f"lane{variation}")
        plate.set_pose([*lane.position[:2], *plate.pose[2:]])
        return self.make_instructions(color=self.colors[variation])
