"""Water a plant with a watering can."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import BodySpec, Detected, ListEmpty, Task

PLACES = ((0.0, 0.0), (0.011, 0.0), (-0.011, 0.0), (0.0, 0.011), (0.0, -0.011))
"""Places in the plane of the head of the can where the drops leave it [m]."""
SPREAD = 0.0005
"""Standard deviation of these places [m]."""


class WaterPlants(Task):
    """Five drops leave the can when its head is first above the pot; all five must be on the soil."""

    def init_task(self) -> None:
        """The can may be grasped; success is that every drop is on the soil."""
        self.over_pot = Detected(self.world.frame("head"), self.world.sensor("pour_point"))
        self.soil, self.drops, self.missing = self.world.sensor("soil"), [f"drop{i}" for i in range(len(PLACES))], [""]
        self.places = np.zeros((len(PLACES), 2))
        self.poured = False
        self.register_graspable_objects(["can"])
        self.register_success_conditions([ListEmpty(self.missing)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw the places where the drops leave the head; only these and the placement of the task vary."""
        self.poured, self.missing[:] = False, self.drops
        self.places[:] = PLACES + rng.normal(0.0, SPREAD, self.places.shape)
        return self.make_instructions()

    def step(self) -> None:
        """Create the drops when the head is above the pot, and update the list of the drops that are not on the soil."""
        if not self.poured and self.over_pot.met():
            self.poured = True
            for drop, (x, y) in zip(self.drops, self.places.tolist(), strict=True):
                pose = (x, y, 0.0, 0.0, 0.0, 0.0, 1.0)
                spec = BodySpec(name=drop, asset="objects/drop/drop.urdf", parent="outlet", pose=pose, color=(0.55, 0.80, 0.98))
                self.world.add_body(drop, spec)
        if self.poured:
            self.missing[:] = [drop for drop in self.drops if not self.soil.detects(drop)]

    def cleanup(self) -> None:
        """Remove the drops."""
        for drop in self.drops if self.poured else ():
            self.world.remove_body(drop)
        self.poured = False
