"""Put the missing draughtsmen back on the board."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Condition, DetectedSeveral, NothingGrasped, Task, Waypoint

FIRST, STEP = (-0.095, 0.319), 0.045
"""Place of the first loose piece beside the board, and the distance to each next piece along x [m]."""


class SetupCheckers(Task):
    """All 24 pieces must be on their squares for the start of a game, and be released.

    One to three random pieces start in a row beside the board. Pieces of one colour may change places.
    """

    def init_task(self) -> None:
        """All pieces may be grasped; each round aims at the next loose one."""
        self.missing: list[int] = []
        self.pieces = [self.world.body(f"piece{i}") for i in range(24)]
        self.register_graspable_objects(piece.name for piece in self.pieces)
        self.register_waypoint_ability_start(0, self._aim_at_next_piece)

    def variation_count(self) -> int:
        """One for each number of loose pieces."""
        return 3

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Put random pieces beside the board; success is a piece of the right colour on every square, and an empty gripper."""
        count = variation + 1
        self.missing = sorted(int(i) for i in rng.choice(24, count, replace=False))
        self.register_rounds(count)
        place = self.world.frame("beside")
        for k, index in enumerate(self.missing):
            place.set_local([FIRST[0] + k * STEP, FIRST[1], 0.006, 0.0, 0.0, 0.0, 1.0])
            self.pieces[index].set_pose(place.pose)
        self._aim_at_next_piece()
        self.register_success_conditions([NothingGrasped(self.gripper), *(self._occupied(square) for square in range(24))])
        return self.make_instructions(**_words(count))

    def _occupied(self, square: int) -> Condition:
        """Return the condition of one square: its own piece; if it was empty at the start, any loose piece of the same colour."""
        alike = [i for i in self.missing if (i < 12) == (square < 12)]
        pieces = [self.pieces[i] for i in (alike if square in self.missing else [square])]
        return DetectedSeveral(pieces, self.world.sensor(f"square{square}"), 1)

    def _aim_at_next_piece(self, waypoint: Waypoint | None = None) -> None:
        index = self.missing[self.round]
        self.world.frame("waypoint1").set_parent(f"piece{index}")
        self.world.frame("waypoint4").set_parent(f"square{index}")


def _words(count: int) -> dict[str, str]:
    """Return the words of the instructions for a number of loose pieces."""
    number = ("one", "two", "three")[count - 1]
    if count == 1:
        return {
            "number": number,
            "pieces": "piece",
            "lie": "lies",
            "are": "is",
            "need": "needs",
            "them": "it",
            "squares": "its own square",
            "starting": "its starting square",
            "places": "place",
            "each": "the loose piece",
        }
    return {
        "number": number,
        "pieces": "pieces",
        "lie": "lie",
        "are": "are",
        "need": "need",
        "them": "them",
        "squares": "their own squares",
        "starting": "their starting squares",
        "places": "places",
        "each": f"each of the {number} loose pieces",
    }
