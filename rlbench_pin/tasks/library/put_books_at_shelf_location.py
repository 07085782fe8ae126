"""Put two books into one compartment of a bookcase."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Detected, NothingGrasped, SpawnBoundary, Task, Waypoint

BOOKS = ("book_blue", "book_red")
APART, TURN = 0.14, 0.5
"""Distance of the books from each other on the table [m], and how far each is turned at most, to either side [rad]."""


class PutBooksAtShelfLocation(Task):
    """Both books must be in the asked one of four compartments, let go.

    Which compartment is asked for varies, and where the books stand on the table.
    """

    compartments = ("upper_left", "upper_right", "lower_left", "lower_right")

    def init_task(self) -> None:
        """Both books may be grasped; each round aims at the next one."""
        self.books = [self.world.body(name) for name in BOOKS]
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(BOOKS)
        self.register_rounds(len(BOOKS))
        self.register_waypoint_ability_start(0, self._aim_at_next_book)

    def variation_count(self) -> int:
        """One for each compartment."""
        return len(self.compartments)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the books; success is both in the asked compartment, let go."""
        self.compartment = self.compartments[variation]
        self.register_rounds(len(BOOKS))
        self.patch.clear()
        for book in self.books:
            self.patch.sample(book, rng, min_rotation=(0.0, 0.0, -TURN), max_rotation=(0.0, 0.0, TURN), min_distance=APART)
        sensor = self.world.sensor(f"in_{self.compartment}")
        self.register_success_conditions([*(Detected(book, sensor) for book in self.books), NothingGrasped(self.gripper)])
        place = self.compartment.replace("_", " ")
        return [
            f"Put both books in the {place} compartment of the bookcase.",
            f"The two books belong at the {place} of the shelf, seen from its open side.",
            f"Clear the table: every book goes into the compartment at the {place}.",
        ]

    def _aim_at_next_book(self, waypoint: Waypoint) -> None:
        """Go for the next book, and for the next place in the compartment."""
        self.world.frame("waypoint1").set_parent(BOOKS[self.round])
        self.world.frame("waypoint4").set_parent(f"{self.compartment}_{self.round}")
