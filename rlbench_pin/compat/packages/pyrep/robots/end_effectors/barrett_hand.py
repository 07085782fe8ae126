"""The Barrett hand, which the catalogue does not have yet."""

from __future__ import annotations

from pyrep.robots.end_effectors.gripper import Gripper


class BarrettHand(Gripper):
    """The Barrett hand; making one raises an error that says which hands there are."""

    def __init__(self, count: int = 0) -> None:
        super().__init__(count, "BarrettHand", ())
