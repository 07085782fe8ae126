"""Wipe the stains off the table with a sponge."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import NO_ROTATION, BodySpec, ListEmpty, SpawnBoundary, Task

STAINS = 50
WIPING = 0.015
"""The sponge removes stains while its underside is at most this height above the table [m]."""


class WipeDesk(Task):
    """The sponge must pass over all fifty stains in a patch of the table; it removes the stains under it."""

    def init_task(self) -> None:
        """The sponge may be grasped; success is that no stain is left."""
        self.wiper, self.boundary = self.world.sensor("under_sponge"), SpawnBoundary([self.world.region("patch")])
        self.stains: list[str] = []
        self.register_graspable_objects(["sponge"])
        self.register_success_conditions([ListEmpty(self.stains)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the stains at random in the patch."""
        self.boundary.clear()
        self.stains[:] = [f"stain{i}" for i in range(STAINS)]
        place = tuple(self.world.region("patch").local)
        spec = BodySpec(name="stain", asset="objects/stain/stain.urdf", pose=place, fixed=True, collides=False)
        for name in self.stains:
            stain = self.world.add_body(name, spec)
            self.boundary.sample(stain, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION, min_distance=0.0)
        return self.make_instructions()

    def step(self) -> None:
        """Remove the stains under the sponge while it is on the table."""
        if self.wiper.position[2] > self.world.root.position[2] + WIPING:
            return
        for name in [name for name in self.stains if self.wiper.detects(name)]:
            self.stains.remove(name)
            self.world.remove_body(name)

    def cleanup(self) -> None:
        """Remove the stains that are left."""
        for name in self.stains:
            self.world.remove_body(name)
        self.stains.clear()
