"""The hand of the Panda."""

from __future__ import annotations

from pyrep.robots.end_effectors.gripper import Gripper


class PandaGripper(Gripper):
    """The hand of the Panda of the running world.

    Args:
        count: Which one, counted from 0; a world has one.
    """

    def __init__(self, count: int = 0) -> None:
        super().__init__(count, "Panda_gripper", ["Panda_gripper_joint1", "Panda_gripper_joint2"])
