"""Lift one of five toy shapes to a floating marker."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import NO_ROTATION, Detected, Grasped, SpawnBoundary, Task


class PickAndLiftSmall(Task):
    """The gripper must hold the requested one of five shapes at the marker. Shapes and marker start at random places."""

    shapes = ("cube", "cylinder", "prism", "star", "moon")
    words = ("cube", "cylinder", "triangular prism", "star", "moon")

    def init_task(self) -> None:
        """All shapes may be grasped."""
        self.marker, self.goal = self.world.body("marker"), self.world.sensor("goal")
        self.boundary = SpawnBoundary([self.world.region("boundary")])
        self.register_graspable_objects(self.shapes)

    def variation_count(self) -> int:
        """One for each shape."""
        return len(self.shapes)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place marker and shapes; success is that the gripper holds the requested shape at the marker."""
        shape, word = self.world.body(self.shapes[variation]), self.words[variation]
        self.boundary.clear()
        self.boundary.sample(self.marker, rng, min_rotation=NO_ROTATION, max_rotation=NO_ROTATION)
        for name in self.shapes:
            self.boundary.sample(self.world.body(name), rng, min_distance=0.1)
        self.world.frame("waypoint1").set_parent(f"grasp_{shape.name}")
        self.register_success_conditions([Grasped(self.gripper, shape), Detected(shape, self.goal)])
        return self.make_instructions(word=word)
