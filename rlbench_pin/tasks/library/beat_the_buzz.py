"""Lead a ring along a rod without touching it."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class BeatTheBuzz(Task):
    """The wand must be let go at the right end of the rod; touching the live part of the rod on the way ends the episode."""

    def init_task(self) -> None:
        wand = self.world.body("wand")
        self.register_graspable_objects(["wand"])
        self.register_success_conditions([Detected(wand, self.world.sensor("end")), NothingGrasped(self.gripper)])
        self.register_fail_conditions([Detected(wand, self.world.sensor("touch"))])

    def variation_count(self) -> int:
        return 1

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        return [
            "Lead the ring to the right end of the rod without touching it.",
            "Beat the buzzer: bring the wand along the wire and leave it at the far end.",
            "Play the hot wire game with a calm hand, all the way to the other post.",
        ]
