"""Lift a cylinder to a floating marker."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, NO_ROTATION, Detected, Grasped, SpawnBoundary, Task, fill_up_colors


class PickAndLiftCylinder(Task):
    """The gripper must hold the cylinder at the marker. The cylinder, two cubes and the marker start at random places."""

    word = "cylinder"
    """What instructions call the toy."""

    def init_task(self) -> None:
        """The toy may be grasped; success is that the gripper holds it at the marker."""
        self.toy, self.marker = self.world.body("toy"), self.world.body("marker")
        self.cubes = [self.world.body("distractor0"), self.world.body("distractor1")]
        self.boundary = SpawnBoundary([self.world.region("boundary")])
        self.register_graspable_objects(["toy"])
        self.register_success_conditions([Grasped(self.gripper, self.toy), Detected(self.toy, self.world.sensor("goal"))])

    def variation_count(self) -> int:
        """One, because only the toy has this shape."""
        return 1

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Colour the two cubes, then place marker, toy and cubes."""
        for cube, color in zip(self.cubes, fill_up_colors(rng, (), len(self.cubes), COLORS), strict=True):
            cube.set_color(color.rgb)
        self.boundary.clear()
        self.boundary.sample(self.marker, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION)
        for body in (self.toy, *self.cubes):
            self.boundary.sample(body, rng, min_distance=0.1)
        return self.make_instructions(word=self.word)

    def get_low_dim_state(self) -> np.ndarray:
        """Return the positions of toy and marker, shape (6,) [m]."""
        return np.concatenate([self.toy.position, self.marker.position])
