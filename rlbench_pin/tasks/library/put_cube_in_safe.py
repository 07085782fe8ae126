"""Put a cube into a safe."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import AnyOf, Detected, NothingGrasped, SpawnBoundary, Task


class PutCubeInSafe(Task):
    """The cube must be in the open safe, on any of its three levels, and be released. Its place on the table varies."""

    levels = ("bottom", "middle", "top")

    def init_task(self) -> None:
        """The cube may be grasped; success is the cube on a level of the safe, and an empty gripper."""
        self.cube = self.world.body("cube")
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["cube"])
        inside = AnyOf([Detected(self.cube, self.world.sensor(f"in_{level}")) for level in self.levels])
        self.register_success_conditions([inside, NothingGrasped(self.gripper)])

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the cube."""
        self.patch.clear()
        self.patch.sample(self.cube, rng, min_rotation=(0.0, 0.0, 0.0), max_rotation=(0.0, 0.0, np.pi / 2.0))
        return self.make_instructions()
