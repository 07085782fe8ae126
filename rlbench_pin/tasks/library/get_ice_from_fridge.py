"""Hold a cup to the ice dispenser of a fridge."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, JointMoved, Task

BRIGHT, DARK = (0.35, 0.85, 1.0), (0.10, 0.16, 0.18)


class GetIceFromFridge(Task):
    """The tongue in the niche must be pushed by 1 degree, the mouth of the cup below the outlet. A light says that ice comes."""

    def init_task(self) -> None:
        """The cup may be grasped; success is the tongue pushed with the cup in the niche, upright."""
        self.fridge = self.world.body("fridge")
        self.pushed = JointMoved(self.world.joint("fridge/tongue_joint"), 0.01745)
        below = Detected(self.world.frame("mouth"), self.world.sensor("niche"))
        self.register_graspable_objects(["cup"])
        self.register_success_conditions([self.pushed, below])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Begin with the light off; only the place of the task varies."""
        self.step()
        return self.make_instructions()

    def step(self) -> None:
        """Let the light follow the tongue."""
        self.fridge.set_color(BRIGHT if self.pushed.met() else DARK, "light")
