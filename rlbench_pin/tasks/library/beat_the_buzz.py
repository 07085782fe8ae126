"""Lead a ring along a rod without touching it."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class BeatTheBuzz(Task):
    """The wand must be let go at the right end of the rod; touching the live part of the rod on the way ends the episode."""

    def init_task(self) -> None:
        """The wand may be grasped; touching the live part of the rod is the fail condition."""
        wand = self.world.body("wand")
        self.register_graspable_objects(["wand"])
        self.register_success_conditions([Detected(wand, self.world.sensor("end")), NothingGrasped(self.gripper)])
        self.register_fail_conditions([Detected(wand, self.world.sensor("touch"))])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return [
            "Move the ring to the other end of the rod without touching the rod, and let go of it there.",
            "The ring belongs at the opposite end of the wire: take it there without a single touch, and release it.",
            "Play the hot wire game: lead the loop over to the other post, clear of the wire, and leave it there.",
        ]
