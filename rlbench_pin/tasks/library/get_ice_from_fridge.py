"""Hold a cup to the ice dispenser of a fridge."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, JointMoved, Task

BRIGHT, DARK = (0.35, 0.85, 1.0), (0.10, 0.16, 0.18)


class GetIceFromFridge(Task):
    """The cup must push the lever in the niche by 1 degree, with its mouth below the outlet. A light shows that ice comes."""

    def init_task(self) -> None:
        """The cup may be grasped; success is the lever pushed while the upright cup is in the niche."""
        self.fridge = self.world.body("fridge")
        self.pushed = JointMoved(self.world.joint("fridge/tongue_joint"), 0.01745)
        below = Detected(self.world.frame("mouth"), self.world.sensor("niche"))
        self.register_graspable_objects(["cup"])
        self.register_success_conditions([self.pushed, below])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Switch the light off; only the placement of the task varies."""
        self.step()
        return self.make_instructions()

    def step(self) -> None:
        """Light the lamp while the lever is pushed."""
        self.fridge.set_color(BRIGHT if self.pushed.met() else DARK, "light")
