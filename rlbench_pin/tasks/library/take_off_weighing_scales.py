"""Take the pepper of the requested colour off kitchen scales."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task, Tray, easiest_top_grasp

NEEDLE_TURN = 130.0
"""Rotation of the needle per displacement of the tray [rad/m]."""
UNLOADED = 0.004
"""Rest position of the empty tray [m]; the needle then points up."""
NO_WALLS = np.array([1.0, 1.0])
"""Half size of the tray for the grasp search: so large that its rim, which is below the fingers, is no obstacle [m]."""


class TakeOffWeighingScales(Task):
    """The requested one of three peppers must be on the table in front of the dial, and be released; all start on the tray.

    The requested pepper and the places of all three on the tray vary.
    """

    colors = ("green", "red", "yellow")

    def init_task(self) -> None:
        """All peppers may be grasped."""
        self.tray, self.needle = self.world.joint("scales/tray"), self.world.joint("scales/needle")
        self.peppers = [self.world.body(f"pepper_{color}") for color in self.colors]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(pepper.name for pepper in self.peppers)

    def variation_count(self) -> int:
        """One for each colour."""
        return len(self.colors)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the peppers; success is the requested one on the table, and an empty gripper."""
        color, pepper = self.colors[variation], self.peppers[variation]
        self.boundary.scatter(self.peppers, rng, min_distance=0.09)
        self.step()
        above = self.world.frame("waypoint0")
        above.set_parent(pepper.name)
        grasp = easiest_top_grasp([pepper], self.peppers, Tray(self.world.body("scales").pose, NO_WALLS))
        above.set_pose(grasp.tip_pose(pepper.position[2] + above.local[2]))
        self.register_success_conditions([NothingGrasped(self.gripper), Detected(pepper, self.world.sensor("on_table"))])
        return self.make_instructions(color=color)

    def step(self) -> None:
        """Rotate the needle in proportion to the displacement of the tray."""
        self.needle.set_position(NEEDLE_TURN * (UNLOADED - self.tray.position))
