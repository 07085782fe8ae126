"""Throw the crumpled paper into the bin."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task, swap_places


class PutRubbishInBin(Task):
    """The paper must be at the bottom of the bin. It starts at one of three places; tomatoes are at the others."""

    def init_task(self) -> None:
        """The paper may be grasped; success is the paper at the bottom of the bin."""
        self.rubbish = self.world.body("rubbish")
        self.tomatoes = [self.world.body("tomato0"), self.world.body("tomato1")]
        self.register_graspable_objects(["rubbish"])
        self.register_success_conditions([Detected(self.rubbish, self.world.sensor("bottom"))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw the place of the paper from the three places."""
        choice = int(rng.integers(3))
        if choice > 0:
            swap_places(self.rubbish, self.tomatoes[choice - 1])
        return self.make_instructions()
