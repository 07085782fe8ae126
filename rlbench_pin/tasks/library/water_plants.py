"""Water a plant with a watering can."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import BodySpec, Detected, ListEmpty, Task

PLACES = ((0.0, 0.0), (0.011, 0.0), (-0.011, 0.0), (0.0, 0.011), (0.0, -0.011))
"""Where the drops leave the head of the can, in its plane [m]."""
SPREAD = 0.0005
"""Standard deviation of these places [m]."""


class WaterPlants(Task):
    """Five drops leave the can when its head is over the pot for the first time; all must lie on the soil."""

    def init_task(self) -> None:
        """The can may be grasped; success is that no drop is missing on the soil."""
        self.over_pot = Detected(self.world.frame("head"), self.world.sensor("pour_point"))
        self.soil, self.drops, self.missing = self.world.sensor("soil"), [f"drop{i}" for i in range(len(PLACES))], [""]
        self.places = np.zeros((len(PLACES), 2))
        self.poured = False
        self.register_graspable_objects(["can"])
        self.register_success_conditions([ListEmpty(self.missing)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Draw where the drops will leave the head; only this and the place of the task vary."""
        self.poured, self.missing[:] = False, self.drops
        self.places[:] = PLACES + rng.normal(0.0, SPREAD, self.places.shape)
        return self.make_instructions()

    def step(self) -> None:
        """Let the drops out when the head is over the pot, and note which of them are not on the soil."""
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
