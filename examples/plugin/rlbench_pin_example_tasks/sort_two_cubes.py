"""Put each of two cubes on the square of its colour."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import COLORS, Detected, NothingGrasped, SpawnBoundary, Task, Waypoint

RGB = dict(COLORS)
PAIRS = (("red", "blue"), ("yellow", "green"), ("white", "orange"), ("purple", "cyan"))
"""Colours of the two cubes, one pair for each variation."""


class SortTwoCubes(Task):
    """Both cubes have to be on their squares, released. The colours vary, and the positions are random in a region."""

    def init_task(self) -> None:
        """Either cube may be grasped; each round takes one cube to its square."""
        self.cubes = [self.world.body(f"cube{i}") for i in range(2)]
        self.squares = [self.world.body(f"square{i}") for i in range(2)]
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(["cube0", "cube1"])
        on_squares = [Detected(cube, self.world.sensor(f"on_square{i}")) for i, cube in enumerate(self.cubes)]
        self.register_success_conditions([*on_squares, NothingGrasped(self.gripper)])
        self.register_waypoint_ability_start(0, self._aim)

    def variation_count(self) -> int:
        """One for each pair of colours."""
        return len(PAIRS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Set the colours, then scatter cubes and squares at least 12 cm apart."""
        first, second = PAIRS[variation]
        for name, cube, square in zip(PAIRS[variation], self.cubes, self.squares, strict=True):
            cube.set_color(RGB[name])
            square.set_color(RGB[name])
        self.patch.scatter([*self.squares, *self.cubes], rng, min_distance=0.12)
        self.register_rounds(2)
        return [
            f"Put the {first} cube on the {first} square and the {second} cube on the {second} square.",
            f"Sort the {first} and the {second} cube onto the squares of their colours.",
            f"Each cube belongs on the square that looks like it: {first} on {first}, {second} on {second}.",
        ]

    def _aim(self, waypoint: Waypoint) -> None:
        """Attach the waypoints of this round to its cube and its square."""
        self.world.frame("waypoint1").set_parent(f"cube{self.round}")
        self.world.frame("waypoint4").set_parent(f"square{self.round}")
