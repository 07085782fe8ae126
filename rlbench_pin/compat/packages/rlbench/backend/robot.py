"""An arm with a hand."""

from __future__ import annotations

from pyrep.robots.arms import Arm
from pyrep.robots.end_effectors import Gripper


class Robot:
    """An arm and the hand that it carries.

    Args:
        arm: The arm.
        gripper: The hand.
    """

    def __init__(self, arm: Arm, gripper: Gripper) -> None:
        self.arm, self.gripper = arm, gripper
