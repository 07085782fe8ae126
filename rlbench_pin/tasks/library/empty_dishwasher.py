"""Take the plate out of a dishwasher that is shut."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, Task, Waypoint


class EmptyDishwasher(Task):
    """The plate must be out of the rack, wherever the rack is; it need not be let go."""

    def init_task(self) -> None:
        """The plate may be grasped; waypoint 12 goes to where the rack has brought it."""
        self.plate = self.world.body("plate")
        self.register_graspable_objects(["plate"])
        self.register_success_conditions([Detected(self.plate, self.world.sensor("rack_space"), negated=True)])
        self.register_waypoint_ability_start(12, self._aim_at_plate)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Return the sentences; only the place of the task varies."""
        return self.make_instructions()

    def _aim_at_plate(self, waypoint: Waypoint) -> None:
        """Go for the plate where the rack has brought it."""
        self.world.frame("plate_place").set_position(self.plate.position)
