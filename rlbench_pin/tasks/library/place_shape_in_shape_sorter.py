"""Drop a toy shape through the matching hole."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, SpawnBoundary, Task, Waypoint, clearance

FREE = 0.085
"""Distance from the requested shape to the others, so that the fingers fit [m]."""


class PlaceShapeInShapeSorter(Task):
    """The requested one of five shapes must be on the floor of the sorter box.

    The requested shape and the places of all five vary.
    """

    shapes = ("cube", "cylinder", "prism", "star", "moon")
    words = ("cube", "cylinder", "triangular prism", "star", "moon")

    def init_task(self) -> None:
        """All shapes may be grasped; the waypoints aim at the requested shape and at its hole."""
        self.shape = self.shapes[0]
        self.boundary = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(self.shapes)
        self.register_waypoint_ability_start(0, self._aim_at_shape)
        self.register_waypoint_ability_start(3, self._aim_at_hole)

    def variation_count(self) -> int:
        """One for each shape."""
        return len(self.shapes)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the shapes at random, with space for the fingers around the requested shape."""
        self.shape, word = self.shapes[variation], self.words[variation]
        asked, shapes = self.world.body(self.shape), [self.world.body(name) for name in self.shapes]
        self.boundary.scatter(shapes, rng, min_distance=0.05, accept=lambda: clearance(asked, shapes) > FREE)
        self._aim_at_shape()
        self._aim_at_hole()
        self.register_success_conditions([Detected(asked, self.world.sensor("inside"))])
        return self.make_instructions(word=word)

    def _aim_at_shape(self, waypoint: Waypoint | None = None) -> None:
        self.world.frame("waypoint1").set_parent(f"grasp_{self.shape}")

    def _aim_at_hole(self, waypoint: Waypoint | None = None) -> None:
        self.world.frame("waypoint4").set_parent(f"drop_{self.shape}")
