"""Return stray chess pieces to their start squares."""

from __future__ import annotations

import numpy as np

from rlbench_pin.tasks import Condition, DetectedSeveral, NothingGrasped, Task, Waypoint

PITCH = 0.047888
"""Distance between neighbouring squares [m]."""
GRIP = {"pawn": 0.043, "rook": 0.047, "knight": 0.051, "bishop": 0.055, "queen": 0.061, "king": 0.067}
"""Grasp height of each kind above its foot [m]."""
COUNTS = {"pawn": 8, "rook": 2, "knight": 2, "bishop": 2, "queen": 1, "king": 1}
MEN = tuple((color, kind, i) for color in ("white", "black") for kind, count in COUNTS.items() for i in range(count))
"""Colour, kind and number of all 32."""
ON_BOARD, ABOVE = 0.015, 0.001
"""Height of the board, and height above it at which a piece is released [m]."""


class SetupChess(Task):
    """All 32 pieces must stand on their squares for the start of a game, and be released.

    One to three random pieces start on the two middle ranks. Pieces of the same kind and colour may change places.
    """

    def init_task(self) -> None:
        """All pieces may be grasped; each round returns the next stray piece."""
        self.stray: list[int] = []
        self.men = [self.world.body(f"{color}_{kind}{i}") for color, kind, i in MEN]
        self.register_graspable_objects(man.name for man in self.men)
        self.register_waypoint_ability_start(0, self._aim_at_next_man)

    def variation_count(self) -> int:
        """One for each number of stray pieces."""
        return 3

    def init_episode(self, variation: int, rng: np.random.Generator) -> list[str]:
        """Put the stray pieces on random squares of the middle ranks."""
        count = variation + 1
        self.stray = [int(i) for i in rng.choice(len(MEN), count, replace=False)]
        self.register_rounds(count)
        place = self.world.frame("stray")
        for man, square in zip(self.stray, rng.choice(16, count, replace=False), strict=True):
            rank, file = divmod(int(square), 8)
            place.set_local([PITCH * (file - 3.5), PITCH * (rank - 0.5), ON_BOARD, *self.men[man].pose[3:]])
            self.men[man].set_pose(place.pose)
        self._aim_at_next_man()
        self.register_success_conditions([NothingGrasped(self.gripper), *(self._filled(i) for i in range(len(MEN)))])
        number = ("one", "two", "three")[variation]
        one = {"pieces": "piece", "squares": "its home square", "them": "it", "are": "is", "they_start": "it starts"}
        several = {"pieces": "pieces", "squares": "their home squares", "them": "them", "are": "are", "they_start": "they start"}
        each = "the one stray piece in the middle" if count == 1 else f"each of the {number} stray pieces in the middle"
        return self.make_instructions(number=number, each=each, **(one if count == 1 else several))

    def _filled(self, home: int) -> Condition:
        """Return the condition of a home square: its own piece; if that is stray, any stray piece of the same kind and colour."""
        alike = [i for i in self.stray if MEN[i][:2] == MEN[home][:2]]
        men = [self.men[i] for i in (alike if home in self.stray else [home])]
        return DetectedSeveral(men, self.world.sensor(f"home_{self.men[home].name}"), 1)

    def _aim_at_next_man(self, waypoint: Waypoint | None = None) -> None:
        man = self.stray[self.round]
        name, grip = self.men[man].name, GRIP[MEN[man][1]]
        for number, parent, height in ((1, name, grip), (4, f"foot_{name}", grip + ABOVE)):
            frame = self.world.frame(f"waypoint{number}")
            frame.set_parent(parent)
            frame.set_local([0.0, 0.0, height, *frame.local[3:]])
