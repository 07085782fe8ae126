"""Open a dishwasher and take the plate out."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task, Waypoint


class EmptyDishwasher(Task):
    """The plate must be out of the rack, at any position of the rack; it may still be held."""

    def init_task(self) -> None:
        """The plate may be grasped; waypoint 12 moves to the plate in the pulled-out rack."""
        self.plate = self.world.body("plate")
        self.register_graspable_objects(["plate"])
        self.register_success_conditions([Detected(self.plate, self.world.sensor("rack_space"), negated=True)])
        self.register_waypoint_ability_start(12, self._aim_at_plate)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the instructions; only the placement of the task varies."""
        return self.make_instructions()

    def _aim_at_plate(self, waypoint: Waypoint) -> None:
        """Aim at the plate in the pulled-out rack."""
        self.world.frame("plate_place").set_position(self.plate.position)
