"""Throw the crumpled paper into the bin of the requested colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task, swap_places


class PutRubbishInColorBin(Task):
    """The paper must be at the bottom of the requested one of two bins, and be released.

    The order of the bins and the place of the paper, one of three, vary; tomatoes are at the other places.
    """

    colors = ("green", "blue")

    def init_task(self) -> None:
        """The paper may be grasped."""
        self.rubbish = self.world.body("rubbish")
        self.tomatoes = [self.world.body("tomato0"), self.world.body("tomato1")]
        self.register_graspable_objects(["rubbish"])

    def variation_count(self) -> int:
        """One for each bin."""
        return len(self.colors)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw the places, and aim at the requested bin; success is the paper in this bin, and an empty gripper."""
        color, choice = self.colors[variation], int(rng.integers(3))
        if choice > 0:
            swap_places(self.rubbish, self.tomatoes[choice - 1])
        if rng.random() < 0.5:
            swap_places(self.world.body("green_bin"), self.world.body("blue_bin"))
        self.world.frame("waypoint3").set_parent(f"{color}_bin")
        lies = Detected(self.rubbish, self.world.sensor(f"{color}_bottom"))
        self.register_success_conditions([lies, NothingGrasped(self.gripper)])
        return self.make_instructions(color=color)
