"""Weigh the pepper of the requested colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task

NEEDLE_TURN = 120.0
"""Rotation of the needle per displacement of the tray [rad/m]."""


class WeighingScales(Task):
    """The requested one of three peppers must be on the tray, released, with the needle at the weight of one pepper.

    The requested pepper and the places of all three on the table vary.
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
        """Place the peppers; success is the requested one on the tray, the needle at its weight, and an empty gripper."""
        color, pepper = self.colors[variation], self.peppers[variation]
        self.boundary.scatter(self.peppers, rng, min_distance=0.12)
        self.world.frame("waypoint0").set_parent(pepper.name)
        weighed = Detected(self.world.frame("needle_end"), self.world.sensor("needle_zone"))
        self.register_success_conditions([NothingGrasped(self.gripper), weighed, Detected(pepper, self.world.sensor("tray"))])
        return self.make_instructions(color=color)

    def step(self) -> None:
        """Rotate the needle in proportion to the displacement of the tray."""
        self.needle.set_position(self.zero - NEEDLE_TURN * (self.tray.position - self.unloaded))
