"""Move a ring along a rod without touching the rod."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task

OFF, DONE, TOUCHED = (0.30, 0.30, 0.32), (0.15, 0.95, 0.25), (1.0, 0.05, 0.03)


class BeatTheBuzz(Task):
    """The wand must be released at the right end of the rod; the episode fails when the wand touches the live part of the rod.

    A lamp is red during a touch, green while the goal is reached, and otherwise off.
    """

    def init_task(self) -> None:
        """The wand may be grasped; the fail condition is contact with the live part of the rod."""
        wand = self.world.body("wand")
        self.register_graspable_objects(["wand"])
        self.at_end, self.let_go = Detected(wand, self.world.sensor("end")), NothingGrasped(self.gripper)
        self.touch = Detected(wand, self.world.sensor("touch"))
        self.register_success_conditions([self.at_end, self.let_go])
        self.register_fail_conditions([self.touch])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Switch the lamp off; only the placement of the task varies."""
        self.world.body("base").set_color(OFF, "lamp")
        return self.make_instructions()

    def step(self) -> None:
        """Set the colour of the lamp after a touch, and when the goal is reached."""
        color = TOUCHED if self.touch.met() else DONE if self.at_end.met() and self.let_go.met() else OFF
        self.world.body("base").set_color(color, "lamp")
