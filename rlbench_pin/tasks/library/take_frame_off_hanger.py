"""Take a framed picture off its hook on the wall."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AllOf, Detected, Grasped, InOrder, NothingGrasped, Task


class TakeFrameOffHanger(Task):
    """The frame must be carried to the table in front of the wall, lie there, and be released.

    A frame does not count if it was knocked off the hook or dropped.
    It lies if the four corners of its back are within 3 cm of the table and 2 cm away from the wall.
    """

    def init_task(self) -> None:
        """The frame may be grasped; success is that it was held at the table, then lies there, off the hook and released."""
        frame, near_table = self.world.body("frame"), self.world.sensor("near_table")
        self.register_graspable_objects(["frame"])
        off = Detected(frame, self.world.sensor("hook"), negated=True)
        lies = [Detected(self.world.frame(f"corner{i}"), near_table) for i in range(4)]
        on_table = Detected(frame, self.world.sensor("on_table"))
        carried = InOrder([AllOf([Grasped(self.gripper, frame), on_table])])
        self.register_success_conditions([carried, off, on_table, *lies, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()
