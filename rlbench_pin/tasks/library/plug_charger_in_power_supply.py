"""Plug a charger into a wall socket."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task

IDLE, LIVE = (0.98, 0.80, 0.10), (0.15, 0.95, 0.25)


class PlugChargerInPowerSupply(Task):
    """Each pin must reach the bottom of its own hole, and the charger must be released.

    The charger starts on a small stand at a random place on the table. Lights on the wall are green while it is plugged in.
    """

    def init_task(self) -> None:
        """The charger may be grasped; success is each pin in its hole, and an empty gripper."""
        self.stand = self.world.body("stand")
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["charger"])
        self.pins = tuple(
            Detected(self.world.frame(f"{side}_pin"), self.world.sensor(f"{side}_hole")) for side in ("right", "left")
        )
        self.register_success_conditions([*self.pins, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the stand with the charger."""
        self.boundary.scatter([self.stand], rng)
        self.step()
        return self.make_instructions()

    def step(self) -> None:
        """Set the colour of the lights on the wall: they show whether the charger is plugged in."""
        self.world.body("panel").set_color(LIVE if all(pin.met() for pin in self.pins) else IDLE, "light")
