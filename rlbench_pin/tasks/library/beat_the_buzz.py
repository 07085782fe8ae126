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
            "Lead the ring to the other end of the rod, never touching the rod, and let go of it there.",
            "The wand belongs at the opposite end of the wire, where you release it; a single touch on the way ends the game.",
            "Play the hot wire game: clear of the wire, the loop has to cross over to the other post and stay there.",
        ]
