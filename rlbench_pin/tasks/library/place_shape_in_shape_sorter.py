"""Drop a toy shape through the hole that it fits."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, SpawnBoundary, Task, Waypoint

FREE = 0.085
"""Distance of the asked shape from the others [m]."""
ATTEMPTS = 50


class PlaceShapeInShapeSorter(Task):
    """The asked one of five shapes must lie on the floor of the sorter box.

    Which shape is asked for varies, and where the five lie.
    """

    shapes = ("cube", "cylinder", "prism", "star", "moon")
    words = ("cube", "cylinder", "triangular prism", "star", "moon")

    def init_task(self) -> None:
        self.shape = self.shapes[0]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(self.shapes)
        self.register_waypoint_ability_start(0, self._aim_at_shape)
        self.register_waypoint_ability_start(3, self._aim_at_hole)

    def variation_count(self) -> int:
        return len(self.shapes)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        self.shape, word = self.shapes[variation], self.words[variation]
        self._scatter(rng)
        self._aim_at_shape()
        self._aim_at_hole()
        self.register_success_conditions([Detected(self.world.body(self.shape), self.world.sensor("inside"))])
        return [
            f"Push the {word} through the hole it fits.",
            f"Sort the {word} into the toy box.",
            f"Where does the {word} go? Drop it in there.",
        ]

    def _scatter(self, rng: np.random.Generator) -> None:
        """Sample all shapes until the fingers have room around the asked one."""
        bodies = [self.world.body(name) for name in self.shapes]
        asked = self.world.body(self.shape)
        for _ in range(ATTEMPTS):
            self.boundary.clear()
            for body in bodies:
                self.boundary.sample(body, rng, min_distance=0.05)
            gaps = [np.linalg.norm(body.position - asked.position) for body in bodies if body is not asked]
            if min(gaps) > FREE:
                return

    def _aim_at_shape(self, waypoint: Waypoint | None = None) -> None:
        self.world.frame("waypoint1").set_parent(f"grasp_{self.shape}")

    def _aim_at_hole(self, waypoint: Waypoint | None = None) -> None:
        self.world.frame("waypoint4").set_parent(f"drop_{self.shape}")
