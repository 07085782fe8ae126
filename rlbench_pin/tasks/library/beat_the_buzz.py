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
            "Lead the ring to the right end of the rod without touching it.",
            "Beat the buzzer: bring the wand along the wire and leave it at the far end.",
            "Play the hot wire game with a calm hand, all the way to the other post.",
        ]
