"""The robot: an arm with a gripper."""

from __future__ import annotations

from pyrep.robots.arms import Arm
from pyrep.robots.end_effectors import Gripper


class Robot:
    """An arm with its gripper.

    Args:
        arm: The arm.
        gripper: The gripper.
    """

    def __init__(self, arm: Arm, gripper: Gripper) -> None:
        self.arm, self.gripper = arm, gripper
