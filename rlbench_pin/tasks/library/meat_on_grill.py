"""Put one of two pieces of meat on a grill."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class MeatOnGrill(Task):
    """The requested piece of meat must be on the grate of the grill, and be released; both pieces start on the table."""

    meats = ("chicken", "steak")

    def init_task(self) -> None:
        """Both pieces of meat may be grasped."""
        self.grate = self.world.sensor("grate")
        self.register_graspable_objects(self.meats)

    def variation_count(self) -> int:
        """One for each piece of meat."""
        return len(self.meats)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the requested meat; success is the meat on the grate, and an empty gripper."""
        meat = self.world.body(self.meats[variation])
        grasp = self.world.frame("waypoint1")
        grasp.set_position([*meat.position[:2], grasp.position[2]])
        self.register_success_conditions([NothingGrasped(self.gripper), Detected(meat, self.grate)])
        return self.make_instructions(meat=meat.name)
