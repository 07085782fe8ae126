"""The Robotiq 85, which the catalogue does not have yet."""

from __future__ import annotations

from pyrep.robots.end_effectors.gripper import Gripper


class Robotiq85Gripper(Gripper):
    """The Robotiq 85; making one raises an error that says which hands there are."""

    def __init__(self, count: int = 0) -> None:
        super().__init__(count, "Robotiq85Gripper", ())
