"""The hand of the Mico, which the catalogue does not have yet."""

from __future__ import annotations

from pyrep.robots.end_effectors.gripper import Gripper


class MicoGripper(Gripper):
    """The hand of the Mico; making one raises an error that says which hands there are."""

    def __init__(self, count: int = 0) -> None:
        super().__init__(count, "MicoGripper", ())
