"""Lay one of two pieces of meat on a grill."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class MeatOnGrill(Task):
    """The asked meat must lie on the grate of the grill, and be let go; both start on the table beside it."""

    meats = ("chicken", "steak")

    def init_task(self) -> None:
        """Both pieces of meat may be grasped."""
        self.grate = self.world.sensor("grate")
        self.register_graspable_objects(self.meats)

    def variation_count(self) -> int:
        """One for each piece of meat."""
        return len(self.meats)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the asked meat; success is that it lies on the grate, let go."""
        meat = self.world.body(self.meats[variation])
        grasp = self.world.frame("waypoint1")
        grasp.set_position([*meat.position[:2], grasp.position[2]])
        self.register_success_conditions([NothingGrasped(self.gripper), Detected(meat, self.grate)])
        return self.make_instructions(meat=meat.name)
