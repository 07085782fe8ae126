"""Put a wine bottle into the requested notch of a rack; a variant of `stack_wine`, not one of the paper's 106 tasks."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, Task


class PlaceWineAtRackLocation(Task):
    """The bottle must lie in the requested one of the three notches of the upper row, and be released."""

    locations = ("left", "middle", "right")

    def init_task(self) -> None:
        """The bottle may be grasped."""
        self.ends = [self.world.frame(name) for name in ("bottom", "shoulder")]
        self.register_graspable_objects(["bottle"])

    def variation_count(self) -> int:
        """One for each notch."""
        return len(self.locations)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Aim at the requested notch; success is both ends of the belly of the bottle in it, and an empty gripper."""
        location = self.locations[variation]
        self.world.frame("waypoint4").set_parent(location)
        notch = self.world.sensor(f"notch_{location}")
        self.register_success_conditions([*(Detected(end, notch) for end in self.ends), NothingGrasped(self.gripper)])
        where = "in the middle" if location == "middle" else f"on the {location}"
        return self.make_instructions(location=location, where=where)
