"""Put the missing draughtsmen back on the board."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Condition, DetectedSeveral, NothingGrasped, Task, Waypoint

FIRST, STEP = (-0.095, 0.319), 0.045
"""Place of the first loose piece beside the board, and the way to each next one along x [m]."""


class SetupCheckers(Task):
    """All 24 pieces must lie on the squares that are theirs at the start of a game, let go.

    One to three of them lie in a row beside the board; which ones varies. Those of one colour may change places.
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
        """Draw the loose pieces and put them beside the board; success is a piece of its colour on every square, let go."""
        count = variation + 1
        self.missing = sorted(int(i) for i in rng.choice(24, count, replace=False))
        self.register_rounds(count)
        place = self.world.frame("beside")
        for k, index in enumerate(self.missing):
            place.set_local([FIRST[0] + k * STEP, FIRST[1], 0.006, 0.0, 0.0, 0.0, 1.0])
            self.pieces[index].set_pose(place.pose)
        self._aim_at_next_piece()
        self.register_success_conditions([NothingGrasped(self.gripper), *(self._filled(square) for square in range(24))])
        return _sentences(count)

    def _filled(self, square: int) -> Condition:
        """Its own piece on a square; on one that is empty at first any loose piece of its colour, as they look the same."""
        alike = [i for i in self.missing if (i < 12) == (square < 12)]
        pieces = [self.pieces[i] for i in (alike if square in self.missing else [square])]
        return DetectedSeveral(pieces, self.world.sensor(f"square{square}"), 1)

    def _aim_at_next_piece(self, waypoint: Waypoint | None = None) -> None:
        index = self.missing[self.round]
        self.world.frame("waypoint1").set_parent(f"piece{index}")
        self.world.frame("waypoint4").set_parent(f"square{index}")


def _sentences(count: int) -> list[str]:
    """Say how many pieces are loose, and that each belongs on its own square."""
    number = ("One", "Two", "Three")[count - 1]
    pieces, lie, are, them, squares = "pieces", "lie", "are", "them", "their own squares"
    if count == 1:
        pieces, lie, are, them, squares = "piece", "lies", "is", "it", "its own square"
    return [
        f"Return the {number.lower()} loose {pieces} to {squares} on the draughts board.",
        f"{number} {pieces} {lie} beside the board: set {them} back on {squares}.",
        f"Get the draughtsmen ready to play, each on the square where it starts; {number.lower()} {are} off the board.",
    ]
