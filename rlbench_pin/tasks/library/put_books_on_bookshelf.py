"""Put one to three books on the upper board of a bookshelf."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import DetectedSeveral, NothingGrasped, SpawnBoundary, Task, Waypoint

BOOKS = ("book_blue", "book_red", "book_yellow")
APART = 0.13
"""Distance between the books on the table, so that the gripper fits between them [m]."""


class PutBooksOnBookshelf(Task):
    """One, two or three of three books must be on the upper board, and be released; any book counts.

    The requested number and the places of the books on the table vary.
    """

    def init_task(self) -> None:
        """All books may be grasped; each round aims at the next one."""
        self.books = [self.world.body(name) for name in BOOKS]
        self.patch = SpawnBoundary([self.world.region("patch")])
        self.register_graspable_objects(BOOKS)
        self.register_waypoint_ability_start(0, self._aim_at_next_book)

    def variation_count(self) -> int:
        """One for each number of books."""
        return len(BOOKS)

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Place the books; success is the requested number on the upper board, and an empty gripper."""
        count = variation + 1
        self.register_rounds(count)
        self.patch.scatter(self.books, rng, min_distance=APART)
        on_board = DetectedSeveral(self.books, self.world.sensor("upper"), count)
        self.register_success_conditions([on_board, NothingGrasped(self.gripper)])
        number = ("one book", "two books", "three books")[variation]
        them, each = ("it", "the book") if count == 1 else ("them", "each book")
        return self.make_instructions(number=number, them=them, each=each)

    def _aim_at_next_book(self, waypoint: Waypoint) -> None:
        """Aim at the next book, and at the next place on the board."""
        self.world.frame("waypoint1").set_parent(BOOKS[self.round])
        self.world.frame("waypoint4").set_parent(f"place{self.round}")
