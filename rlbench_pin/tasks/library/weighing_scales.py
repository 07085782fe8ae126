"""Weigh the pepper of the asked colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task

NEEDLE_TURN = 120.0
"""Turn of the needle for the drop of the tray [rad/m]."""


class WeighingScales(Task):
    """The asked one of three peppers must lie on the tray, let go, with the needle at the weight of one pepper.

    Which pepper is asked for varies, and where the three lie on the table.
    """

    colors = ("green", "red", "yellow")

    def init_task(self) -> None:
        """All peppers may be grasped."""
        self.tray, self.needle = self.world.joint("scales/tray"), self.world.joint("scales/needle")
        self.unloaded, self.zero = self.tray.position, self.needle.position
        self.peppers = [self.world.body(f"pepper_{color}") for color in self.colors]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(pepper.name for pepper in self.peppers)

    def variation_count(self) -> int:
        """One for each colour."""
        return len(self.colors)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the peppers; success is the asked one on the tray, let go, and the needle at its weight."""
        color, pepper = self.colors[variation], self.peppers[variation]
        self.boundary.scatter(self.peppers, rng, min_distance=0.12)
        self.world.frame("waypoint0").set_parent(pepper.name)
        weighed = Detected(self.world.frame("needle_end"), self.world.sensor("needle_zone"))
        self.register_success_conditions([NothingGrasped(self.gripper), weighed, Detected(pepper, self.world.sensor("tray"))])
        return self.make_instructions(color=color)

    def step(self) -> None:
        """Turn the needle as far as the tray has sunk."""
        self.needle.set_position(self.zero - NEEDLE_TURN * (self.tray.position - self.unloaded))
