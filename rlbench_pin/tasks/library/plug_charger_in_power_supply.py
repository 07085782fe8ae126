"""Plug a charger into a socket in the wall."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task

IDLE, LIVE = (0.98, 0.80, 0.10), (0.15, 0.95, 0.25)


class PlugChargerInPowerSupply(Task):
    """Each pin must reach the bottom of its own hole, and the charger must be let go.

    The place of the charger on the table varies; it lies on a little stand. Lights on the wall turn green while it is plugged in.
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
        """Let the lights of the wall show whether the charger is plugged in."""
        self.world.body("panel").set_color(LIVE if all(pin.met() for pin in self.pins) else IDLE, "light")
