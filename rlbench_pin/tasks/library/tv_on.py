"""Switch a television on with its remote control."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AllOf, Detected, JointMoved, NothingGrasped, SpawnBoundary, Task

SKY, WHITE, DARK = (0.55, 0.80, 1.0), (1.0, 1.0, 1.0), (0.03, 0.03, 0.04)
IMAGE = {"screen": SKY, "hills": (0.20, 0.55, 0.18), "sun": (1.0, 0.85, 0.20), "one": WHITE, "two": SKY, "three": SKY}
"""Link of the television -> its colour while it is on; digits in the colour of the sky are invisible."""


class TvOn(Task):
    """The remote must lie in front of the television, point to it, and be released. Its power button must be down by 3 mm."""

    def init_task(self) -> None:
        """The remote may be grasped by its body; success is its power button pressed while it is released at its goal place."""
        self.television, self.remote = self.world.body("television"), self.world.body("remote")
        self.patches = SpawnBoundary([self.world.region("left"), self.world.region("right")])
        self.register_graspable_objects(["remote/remote"])
        ends = {"tip": "front", "tail": "rear"}
        aimed = [Detected(self.world.frame(end), self.world.sensor(place)) for end, place in ends.items()]
        self.turned_on = AllOf([JointMoved(self.world.joint("remote/power_joint"), 0.003), *aimed, NothingGrasped(self.gripper)])
        self.register_success_conditions([self.turned_on])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the remote beside its goal place, and switch the television off."""
        self.patches.clear()
        self.patches.sample(self.remote, rng)
        self.television.set_color(DARK)
        return self.make_instructions()

    def step(self) -> None:
        """Show an image when the television is on."""
        if self.turned_on.met():
            for link, rgb in IMAGE.items():
                self.television.set_color(rgb, link)
