"""The hand of the Baxter, which the catalogue does not have yet."""

from __future__ import annotations

from pyrep.robots.end_effectors.gripper import Gripper


class BaxterGripper(Gripper):
    """The hand of the Baxter; making one raises an error that says which hands there are."""

    def __init__(self, count: int = 0) -> None:
        super().__init__(count, "BaxterGripper", ())
