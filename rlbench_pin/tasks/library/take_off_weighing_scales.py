"""Take the pepper of the asked colour off kitchen scales."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task, Tray, easiest_top_grasp

NEEDLE_TURN = 130.0
"""Turn of the needle for the drop of the tray [rad/m]."""
UNLOADED = 0.004
"""Where the empty tray is in balance [m]; the needle points up then."""
NO_WALLS = np.array([1.0, 1.0])
"""Half size of a tray that is not an obstacle to the fingers: its rim is below them [m]."""


class TakeOffWeighingScales(Task):
    """The asked one of three peppers must lie on the table before the dial, let go; all start on the tray.

    Which pepper is asked for varies, and where the three lie on the tray.
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
        """Place the peppers; success is the asked one on the table, let go."""
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
        """Turn the needle as far as the tray has sunk."""
        self.needle.set_position(NEEDLE_TURN * (UNLOADED - self.tray.position))
