"""Take a framed picture off its hook in the wall."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class TakeFrameOffHanger(Task):
    """The frame must be off the hook, on the table in front of the wall, and let go."""

    solved_by_chance = True  # a blow can knock the frame off and out onto the table

    def init_task(self) -> None:
        """The frame may be grasped; success is that it lies on the table, off the hook and let go."""
        frame = self.world.body("frame")
        self.register_graspable_objects(["frame"])
        off = Detected(frame, self.world.sensor("hook"), negated=True)
        self.register_success_conditions([off, Detected(frame, self.world.sensor("on_table")), NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return [
            "Take the picture off its hook and lay it on the table in front of the wall.",
            "The framed photo should come down: lift it from the peg and let go of it on the tabletop before the wall.",
            "Where the wall faces, on the table, leave the frame that hangs from the hook.",
        ]
