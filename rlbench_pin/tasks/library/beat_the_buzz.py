"""Lead a ring along a rod without touching it."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task

OFF, DONE, TOUCHED = (0.30, 0.30, 0.32), (0.15, 0.95, 0.25), (1.0, 0.05, 0.03)


class BeatTheBuzz(Task):
    """The wand must be let go at the right end of the rod; touching the live part of the rod on the way ends the episode.

    A lamp shows it: red after a touch, else green while the goal is reached.
    """

    def init_task(self) -> None:
        """The wand may be grasped; touching the live part of the rod is the fail condition."""
        wand = self.world.body("wand")
        self.register_graspable_objects(["wand"])
        self.at_end, self.let_go = Detected(wand, self.world.sensor("end")), NothingGrasped(self.gripper)
        self.touch = Detected(wand, self.world.sensor("touch"))
        self.register_success_conditions([self.at_end, self.let_go])
        self.register_fail_conditions([self.touch])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Switch the lamp off; only the place of the task varies."""
        self.world.body("base").set_color(OFF, "lamp")
        return self.make_instructions()

    def step(self) -> None:
        """Let the lamp show a touch, or that the goal is reached."""
        color = TOUCHED if self.touch.met() else DONE if self.at_end.met() and self.let_go.met() else OFF
        self.world.body("base").set_color(color, "lamp")
