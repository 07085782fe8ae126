"""Put two books into one compartment of a bookcase."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task, Waypoint

BOOKS = ("book_blue", "book_red")
TURN = 0.5
"""Largest yaw of a book on the table, to either side [rad]."""


class PutBooksAtShelfLocation(Task):
    """Both books must be in the requested one of four compartments, and be released.

    The requested compartment and the places of the books on the table vary.
    """

    compartments = ("upper_left", "upper_right", "lower_left", "lower_right")

    def init_task(self) -> None:
        """Both books may be grasped; each round aims at the next one."""
        self.books = [self.world.body(name) for name in BOOKS]
        self.patches = [SpawnBoundary([self.world.region(f"patch{i}")]) for i in range(len(BOOKS))]
        self.register_graspable_objects(BOOKS)
        self.register_waypoint_ability_start(0, self._aim_at_next_book)

    def variation_count(self) -> int:
        """One for each compartment."""
        return len(self.compartments)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the books; success is both in the requested compartment, and an empty gripper."""
        self.compartment = self.compartments[variation]
        self.register_rounds(len(BOOKS))
        for patch, number in zip(self.patches, rng.permutation(len(BOOKS)), strict=True):
            patch.clear()
            patch.sample(self.books[number], rng, min_rotation=(0.0, 0.0, -TURN), max_rotation=(0.0, 0.0, TURN))
        sensor = self.world.sensor(f"in_{self.compartment}")
        self.register_success_conditions([*(Detected(book, sensor) for book in self.books), NothingGrasped(self.gripper)])
        place = self.compartment.replace("_", " ")
        return self.make_instructions(place=place)

    def _aim_at_next_book(self, waypoint: Waypoint) -> None:
        """Aim at the next book, and at the next place in the compartment."""
        self.world.frame("waypoint1").set_parent(BOOKS[self.round])
        self.world.frame("waypoint4").set_parent(f"{self.compartment}_{self.round}")
